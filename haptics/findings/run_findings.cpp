#include "haptics/findings/run_findings.hpp"

#include <algorithm>
#include <iterator>
#include <limits>

#include "core/base/error.hpp"
#include "core/base/percentile.hpp"
#include "haptics/findings/kinds.hpp"

namespace kt {
namespace {

/// The way that the first tool took.
std::vector<Pose> way_of(const ToolRun& run) {
  std::vector<Pose> out{run.start};
  for (const LocalFrame& f : run.frames) out.push_back(f.pose);
  return out;
}

PaceLimits pace_limits(const Session& session, const std::optional<ContactWidth>& width) {
  constexpr double kCoarser = 1.5;  // as long edges: a third of the nodes
  PaceLimits out;
  if (width) {
    out.coarser = stays_fine(session, *width, kCoarser, "");
    out.linear_elements = stays_fine(session, *width, 1, "tet4");
  }
  for (std::size_t k = 0; k < session.tools().size(); ++k) out.tool_triangles[k] = session.tools()[k].triangles.size();
  return out;
}

/// Predictions of the contact's width are left to what the run shows of it.
void add_known(const Session& session, const SessionResult& result, const MeasuredRun& measured,
               std::vector<Finding>& out) {
  std::ranges::copy(result.findings, std::back_inserter(out));
  for (const Prediction& known : session.predictions())
    if (known.failure != "contact_width") out.push_back(known.finding);
  if (measured.width && is_off(*measured.width))
    out.push_back(coarse_mesh_finding(session, *measured.width, measured.pace.refresh_share));
}

}  // namespace

bool keeps_outside(const Scene& scene) { return scene.local.method == "multirate" && scene.contact.law == "coulomb"; }

bool contact_was_lost(const Scene& scene, const SessionResult& result) {
  return keeps_outside(scene) &&
         std::ranges::any_of(result.tools, [](const ToolRun& t) { return t.missed_impacts > 0; });
}

double steady_from(const Scene& scene, const SessionResult& result) {
  constexpr double kSettle = 0.1;  // [s] the press's own transient
  if (scene.tool.path.press_drag) return scene.tool.path.press_drag->press_time + kSettle;
  for (const LocalFrame& f : result.tools[0].frames)
    if (touches(f)) return f.t + kSettle;
  return 0;
}

MeasuredRun measure_run(const Session& session, const SessionResult& result) {
  const Scene& scene = session.scene();
  MeasuredRun out;
  for (const ToolRun& tool : result.tools)
    out.forces.push_back(measure_forces(tool.frames, steady_from(scene, result), 1 / scene.local.rate_hz));
  const std::vector<double>& fineness = result.refresh.fineness;
  out.width =
      find_contact_width(session, way_of(result.tools[0]),
                         fineness.empty() ? std::numeric_limits<double>::quiet_NaN() : percentile(fineness, 0.5));
  out.pace = judge_real_time(scene, result, pace_limits(session, out.width));
  return out;
}

std::vector<Finding> all_findings(const Session& session, const SessionResult& result, const MeasuredRun& measured) {
  const Scene& scene = session.scene();
  std::vector<Finding> out;
  add_known(session, result, measured, out);
  find_old_models(scene, result, measured.pace, out);
  find_withheld_forces(scene, result, out);
  find_in_ticks(scene, result, measured.pace, out);
  find_in_body(session, result, out);
  find_in_motion(scene, result, out);
  find_in_forces(scene, result, measured, out);
  if (result.device_lost)
    out.push_back(Finding{told("the device was lost in tick ", result.tools[0].frames.size(),
                               ", after 10 s without it: the force was zero"),
                          {advise("is it still plugged in and switched on?")},
                          Finding::Weight::failure}
                      .at("tool.path.device"));
  if (result.stopped)
    out.push_back(
        Finding{told("stopped early, after ", result.tools[0].frames.size(), " ticks"), {}, Finding::Weight::failure}
            .at("duration"));
  return out;
}

std::vector<Finding> all_findings(const Session& session, const SessionResult& result) {
  return all_findings(session, result, measure_run(session, result));
}

std::vector<Cure> sooner(const Scene& scene, const RealTime& pace) {
  constexpr double kRoom = 0.8;
  std::vector<Cure> out;
  const double twice = 2 * pace.refresh_share;
  const bool fits = pace.keeps == Keeps::yes && twice <= kRoom;
  if (fits || scene.link.type == "lockstep")
    out.push_back(set_to("global.rate_hz", text(2 * scene.global.rate_hz),
                         fits                       ? ""
                         : pace.keeps == Keeps::yes ? told("a refresh then takes ", in_percent(twice), " of its time")
                                                    : "further from real time"));
  out.push_back(advise("move the tool more slowly"));
  return out;
}

bool is_trustworthy(const std::vector<Finding>& findings) {
  return std::ranges::all_of(findings, [](const Finding& f) { return f.weight == Finding::Weight::note; });
}

bool has_failed(const std::vector<Finding>& findings) {
  return std::ranges::any_of(findings, [](const Finding& f) { return f.weight == Finding::Weight::failure; });
}

}  // namespace kt
