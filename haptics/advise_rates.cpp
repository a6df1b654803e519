// Second half of an advice: global rates and reducers on one body, against the full model along the same path.
#include <time.h>

#include <algorithm>
#include <cmath>

#include "core/parallel.hpp"
#include "haptics/advise_parts.hpp"
#include "haptics/metrics.hpp"
#include "haptics/reference.hpp"

namespace kt {
namespace {

constexpr double kRates[] = {30, 10, 60};  // [Hz]; the most telling first
const char* const kReducers[] = {"auto", "krylov", "condensed", "wall"};
constexpr double kReferenceShare = 0.85;  // of the budget at which the reference ends

double process_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

bool knows_reducer(const std::string& name) {
  return std::ranges::any_of(reducer_backends(), [&](const BackendInfo& b) { return b.name == name && b.available; });
}

/// By size and not by the clock, so that equal scenes get equal references: what ten seconds or so of drag take.
int steps_per_tick(int nodes) { return nodes <= 1000 ? 10 : nodes <= 2500 ? 4 : 2; }

Scene row_scene(const Scene& scene, double rate_hz, const std::string& reducer) {
  Scene out = scene;
  out.global.rate_hz = rate_hz;
  out.local.reducer = reducer;
  if (reducer == "wall") out.local.rings = 1;
  // A model made in another thread is there an interval later.
  if (scene.link.type != "lockstep") out.link.latency_ms += 1e3 / rate_hz;
  out.link.type = "lockstep";
  return out;
}

Reference find_reference(const Session& session, const std::vector<Vec3>& path, const AdviceClock& clock,
                         AdviceReference& out) {
  std::atomic<bool> enough{false};
  ReferenceOptions options;
  options.rate_hz = steps_per_tick(session.model().mesh().num_nodes()) * session.scene().local.rate_hz;
  options.stop = &enough;
  options.progress = [&](double) {
    clock.show();
    if (clock.stopped() || clock.left(kReferenceShare) < 0) enough = true;
  };
  const Reference reference = run_reference(session, path, options);
  out.rate_hz = reference.rate_hz;
  out.cpu_seconds = reference.seconds;
  out.seconds = static_cast<double>(reference.force.size()) * reference.h;
  const double whole = static_cast<double>(path.size() - 1) * reference.h;
  if (out.seconds < whole)
    out.note = text("covers the first ", out.seconds, " s of ", whole, " s: beyond the time budget");
  return reference;
}

/// Forces after the tool has come down, of which there must be some.
bool is_telling(const Reference& reference) {
  double most = 0;
  std::size_t touching = 0;
  for (const Vec3& f : reference.force) most = std::max(most, f.norm());
  for (const Vec3& f : reference.force) touching += f.norm() > 0.2 * most;
  return most > 0 && static_cast<double>(touching) * reference.h > 0.05;
}

void measure_row(const Scene& scene, const Mesh& mesh, const Reference& reference, const AdviceClock& clock,
                 AdviceRow& row) try {
  Session session(scene, mesh);
  SessionOptions options;
  options.check_contacts = false;
  options.stop = clock.stop();
  options.progress = [&](double) { clock.show(); };
  SessionResult result;
  const double cpu = process_seconds(), wall = clock.seconds();
  with_threads(1, [&] { result = session.run(options); });
  if (result.stopped) {
    row.note = "not measured: stopped";
    return;
  }
  // The machine may be shared: wall clock times the share of a core that the run had.
  const double had = std::min(1.0, (process_seconds() - cpu) / (clock.seconds() - wall));
  row.global_ms = had * percentile(result.global_ms, 0.5);
  row.refresh_ms = had * percentile(result.refresh_ms, 0.5);
  row.step_us_p50 = percentile(result.step_us, 0.5);
  row.step_us_p99 = percentile(result.step_us, 0.99);
  const double seconds = static_cast<double>(result.frames.size()) / scene.local.rate_hz;
  row.refreshes_per_second = static_cast<double>(result.refreshes.size()) / seconds;
  row.core_share =
      1e-6 * row.step_us_p50 * scene.local.rate_hz + 1e-3 * (row.global_ms + row.refresh_ms) * row.refreshes_per_second;
  row.dof = result.last_dof;
  const ForceError error = compare_forces(tick_forces(result.frames), reference);
  row.error = error.force_error;
  row.jnd_fraction = error.jnd_fraction;
  row.measured = true;
  for (const std::string& warning : result.warnings)
    if (warning.find("inside out") != std::string::npos) row.note = warning.substr(0, warning.find(':'));
} catch (const RunError& e) {
  row.note = text("not measured: ", e.what());
}

}  // namespace

void measure_rates(const AdviceScene& scene, const Mesh& mesh, const AdviceClock& clock, Advice& out) {
  for (double rate : kRates)
    for (const char* reducer : kReducers)
      if (knows_reducer(reducer) && rate <= scene.scene.local.rate_hz)
        out.rows.push_back({.rate_hz = rate, .reducer = reducer});
  const auto leave_out = [&](std::size_t from, const std::string& why) {
    for (std::size_t i = from; i < out.rows.size(); ++i) out.rows[i].note = "not measured: " + why;
  };
  if (clock.stopped()) return leave_out(0, "stopped");
  Reference reference;
  {
    const Session session(row_scene(scene.scene, 30, "condensed"), mesh);
    std::vector<Vec3> path{session.path().front().x};
    const auto ticks = std::llround(scene.scene.duration * scene.scene.local.rate_hz);
    DeviceOptions scripted;
    scripted.h = 1 / scene.scene.local.rate_hz;
    scripted.path = session.path();
    const auto device = make_device("scripted", scripted);
    path[0] = device->position(0);
    for (int i = 1; i <= ticks; ++i) path.push_back(device->position(i / scene.scene.local.rate_hz));
    reference = find_reference(session, path, clock, out.reference);
  }
  if (clock.stopped()) return leave_out(0, "stopped");
  if (!is_telling(reference))
    return leave_out(0, "the reference did not get to the contact within the time budget; raise --budget-seconds");
  double last = 0;
  for (std::size_t i = 0; i < out.rows.size(); ++i) {
    if (clock.stopped()) return leave_out(i, "stopped");
    if (i > 0 && last > clock.left()) return leave_out(i, "beyond the time budget");
    const double started = clock.seconds();
    AdviceRow& row = out.rows[i];
    measure_row(row_scene(scene.scene, row.rate_hz, row.reducer), mesh, reference, clock, row);
    last = clock.seconds() - started;
  }
}

}  // namespace kt
