// A sphere pressed in at places all over the surface: is the force finite, outward, and growing with the depth?
#include <cmath>
#include <functional>

#include "core/base/error.hpp"
#include "core/base/numbers.hpp"
#include "haptics/cells/contact_width.hpp"
#include "lab/check/hand_paths.hpp"
#include "lab/check/mesh_work.hpp"
#include "lab/check/runs.hpp"

namespace kt {
namespace {

constexpr double kRest = 0.01;  // [s] at the end of each stop

/// Mean force along the normal when the body has come to rest, at each depth [N].
/// @param forces  on the tool, one a tick of h [N]
std::vector<double> force_over_depth(std::span<const Vec3> forces, double h, const PressPath& path,
                                     const Vec3& normal) {
  std::vector<double> out;
  for (const double end : path.rests) {
    double sum = 0;
    int ticks = 0;
    for (std::size_t i = 0; i < forces.size(); ++i)
      if (const double t = static_cast<double>(i + 1) * h; t > end - kRest && t <= end + 0.5 * h) {
        sum += forces[i].dot(normal);
        ++ticks;
      }
    out.push_back(ticks > 0 ? sum / ticks : 0);
  }
  return out;
}

/// @param of_whole_body  the whole nonlinear body's forces at the same depths; empty: not to be had
void judge_forces(const std::vector<double>& force, const std::function<std::vector<double>()>& of_whole_body,
                  const std::string& name, const Vec3& where, StageResult& out) {
  if (!(force.back() > 0)) {
    out.lower(Verdict::fail, told(name, ": the force at full depth is ", force.back(), " N, not outward"), where);
    return;
  }
  const Fall fall = largest_fall(force);
  if (judge_fall(fall, {}) == Verdict::pass) return;
  std::string said =
      told(name, ": deeper, but the force falls from ", force[fall.to - 1], " to ", force[fall.to], " N; ");
  const std::vector<double> truth = of_whole_body();
  std::optional<Fall> its;
  if (!truth.empty()) its = largest_fall(truth);
  if (!its)
    said += "not compared with the whole nonlinear body";
  else if (its->share > 0)
    said += told("that of the whole nonlinear body from ", truth[its->to - 1], " to ", truth[its->to]);
  else
    said += "that of the whole nonlinear body does not";
  out.lower(judge_fall(fall, its), said, where);
}

int free_between(const SessionResult& run, double from, double to) {
  return static_cast<int>(std::ranges::count_if(run.tools[0].frames, [&](const LocalFrame& f) {
    return f.t > from && f.t <= to && f.mode == ContactMode::free;
  }));
}

/// A light body bounces off the tool that stops; by the second half of the hold it must lie against it, unless the
/// whole nonlinear body has swung away, too. Returns whether there is a force to be judged.
bool judge_hold(const CheckBody& body, const SessionResult& run, const PressPath& path, const std::string& name,
                const Vec3& where, const std::atomic<bool>* stop, RunExtremes& all, StageResult& out) {
  const double end = path.rests.back(), settled = 0.5 * (path.pressed + end);
  if (const int bounces = free_between(run, path.pressed, settled); bounces > 0)
    out.lower(Verdict::degraded, text(name, ": the body bounces off for ", bounces, " ticks where the tool stops"),
              where);
  const Loss loss = longest_loss(body, run, settled, end, stop);
  if (loss.ticks == 0) return true;
  all.lost += loss.ticks;
  const Verdict verdict = judge_loss(loss);
  out.lower(verdict, text(name, ": no contact while held, ", loss.told()), where);
  return verdict != Verdict::pass;
}

}  // namespace

void check_press(MeshWork& work, StageResult& out) {
  const auto thickest =
      static_cast<std::size_t>(std::ranges::max_element(work.spots, {}, &ContactSpot::thickness) - work.spots.begin());
  for (CheckBody& body : work.bodies) {
    RunExtremes all;
    double largest = 0, off = std::nan("");
    for (std::size_t i = 0; i < work.spots.size(); ++i) {
      const ContactSpot& spot = work.spots[i];
      const std::string name = text(body.model, ", place ", i + 1);
      const Vec3 where = work.in_file(spot.place);
      const PressPath path = press_path(spot);
      const SessionResult run = run_along(body, path.path, work.options.stop);
      judge_run(run, name, where, all, out);
      const double h = run.tools[0].frames[0].t;
      const auto force = force_over_depth(tick_forces(run.tools[0].frames), h, path, spot.normal);
      const auto of_whole_body = [&] {
        const auto truth = truth_of(body, run, run.tools[0].frames.size(), work.options.stop);
        return truth ? force_over_depth(truth->force, h, path, spot.normal) : std::vector<double>();
      };
      if (judge_hold(body, run, path, name, where, work.options.stop, all, out))
        judge_forces(force, of_whole_body, name, where, out);
      const double held = force.back();
      largest = std::max(largest, held);
      if (i != thickest) continue;
      if (const auto width = find_contact_width(*body.session, places_of(run.tools[0])))
        out.figures[body.model].update(
            {{"cell_over_contact_radius", width->mean},
             {"force_factor", std::isfinite(width->factor) ? nlohmann::ordered_json(width->factor) : nullptr}});
      if (work.options.quick) continue;  // the whole nonlinear body takes as long as the press
      const auto ticks = static_cast<std::size_t>(std::lround(path.rests[1] / h));
      if (const auto truth = truth_of(body, run, ticks, work.options.stop))
        off = compare_forces(tick_forces(run.tools[0].frames), *truth).force_error;
    }
    report_runs(all, body.model, out);
    out.figures[body.model]["largest_force"] = largest;
    out.figures[body.model]["force_error"] = std::isfinite(off) ? nlohmann::ordered_json(off) : nullptr;
  }
}

}  // namespace kt
