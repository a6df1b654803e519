#include "apps/outputs/run_tables.hpp"

#include "core/base/error.hpp"
#include "io/files/output_file.hpp"

namespace kt {
namespace {

/// Parts of a file of some hundred kB: the header, then the rows.
/// @param add  (out, i): the i-th row
template <class AddRow>
void write_rows(ResultFiles& out, const std::string& name, std::string header, std::size_t rows, const AddRow& add) {
  constexpr std::size_t kPart = std::size_t{1} << 18;  // [bytes]
  std::size_t i = 0;
  out.add(name, [&](std::string& part) {
    if (i == rows && header.empty()) return false;
    part = std::exchange(header, {});
    for (; i < rows && part.size() < kPart; ++i) add(part, i);
    return true;
  });
}

}  // namespace

void write_trace(ResultFiles& files, const std::string& name, const ToolRun& run, std::span<const double> step_us,
                 const Indentation& indentation) {
  const auto row = [&](std::string& out, std::size_t i) {
    const LocalFrame& f = run.frames[i];
    const auto number = [&](double value) {
      append_number(out, value);
      out += ',';
    };
    number(f.t);
    for (int c = 0; c < 3; ++c) number(f.pose.x[c]);
    for (int c = 0; c < 3; ++c) number(f.force[c]);
    number(f.f_n);
    number(f.f_t);
    out += text(name_of(f.mode), ',', f.triangle, ',');
    number(f.toi);
    number(f.gap);
    out += text(f.model_frame, ',');
    number(step_us[i]);
    for (const Vec3& v : {f.torque, f.normal, run.model_force[i]})
      for (int c = 0; c < 3; ++c) number(v[c]);
    number(f.mode == ContactMode::free ? 0.0 : indentation.at(f.point, f.normal));
    out.back() = '\n';
  };
  write_rows(
      files, name,
      "t,tool_x,tool_y,tool_z,force_x,force_y,force_z,f_n,f_t,mode,triangle,toi,gap,model_frame,step_us,"
      "torque_x,torque_y,torque_z,normal_x,normal_y,normal_z,model_force_x,model_force_y,model_force_z,indentation\n",
      run.frames.size(), row);
}

void write_events(ResultFiles& files, const std::string& name, std::span<const ContactEvent> events) {
  const auto row = [&](std::string& out, std::size_t i) {
    const ContactEvent& e = events[i];
    append_number(out, e.t);
    out += text(',', name_of(e.kind));
    for (int c = 0; c < 3; ++c) append_number(out += ',', e.place[c]);
    for (int c = 0; c < 3; ++c) append_number(out += ',', e.force[c]);
    append_number(out += ',', e.f_n);
    append_number(out += ',', e.f_t);
    out += text(',', e.triangle_before, ',', e.triangle, '\n');
  };
  write_rows(files, name, "t,event,x,y,z,force_x,force_y,force_z,f_n,f_t,triangle_before,triangle\n", events.size(),
             row);
}

void write_recording(ResultFiles& files, const std::string& name, const ToolRun& run) {
  const auto row = [&](std::string& out, std::size_t i) {
    const double t = i == 0 ? 0 : run.frames[i - 1].t;
    const Pose& pose = i == 0 ? run.start : run.frames[i - 1].pose;
    append_number(out, t);
    for (int c = 0; c < 3; ++c) append_number(out += ',', pose.x[c]);
    for (const double q : {pose.r.w(), pose.r.x(), pose.r.y(), pose.r.z()}) append_number(out += ',', q);
    out += '\n';
  };
  write_rows(files, name, "t,x,y,z,qw,qx,qy,qz\n", run.frames.size() + 1, row);
}

}  // namespace kt
