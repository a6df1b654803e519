// Second part of an advice: global rates and reducers on one body, against its full model along the same path.

#include <algorithm>
#include <cmath>

#include "core/base/cpu_time.hpp"
#include "core/base/parallel.hpp"
#include "haptics/refresh/refresh_cost.hpp"
#include "haptics/session/metrics.hpp"
#include "lab/advise/advise_parts.hpp"
#include "lab/study/reference.hpp"

namespace kt {
namespace {

const char* const kReducers[] = {"condensed", "auto", "wall", "krylov"};
constexpr double kReferenceShare = 0.6;  // of the time that is left for the rates
constexpr double kMargin = 1.5;          // what the next row may take, over what the last one took
constexpr int kMostNodes = 6000;         // of a body whose full model is run: above, one of its matrices takes seconds
constexpr double kShortest = 0.1;        // [s] of the path that say something

/// By size and not by the clock, so that equal scenes get equal references: what ten seconds or so of drag take.
int steps_per_tick(int nodes) { return nodes <= 1000 ? 10 : nodes <= 2500 ? 4 : 2; }

/// Against a full model of the same cells: those of the body as it is.
Session with_own_cells(const Scene& scene, const Mesh& mesh) {
  Scene own = scene;
  own.local.refine = "off";
  return Session(own, mesh);
}

Reference find_reference(const AdviceScene& scene, const Session& session, const AdviceClock& clock) {
  const double end = 1 - (1 - kReferenceShare) * clock.left() / (clock.left() + clock.seconds());
  std::atomic<bool> over{false};
  ReferenceOptions options;
  options.rate_hz = steps_per_tick(session.model().mesh().num_nodes()) * session.scene().local.rate_hz;
  options.stop = &over;
  options.progress = watch(clock, end, over);
  return run_reference(session, {&scene.tool, 1}, options);
}

/// @param had  becomes the share of a core that it had
SessionResult run_row(Session session, const AdviceClock& clock, double& had) {
  std::atomic<bool> over{false};
  SessionOptions options;
  options.check_contacts = false;
  options.stop = &over;
  options.progress = watch(clock, 1, over);
  SessionResult out;
  had = share_of_core([&] { with_threads(1, [&] { out = session.run(options); }); });
  if (out.stopped) throw RunError("beyond the time budget");
  return out;
}

void measure_row(const Scene& scene, const Mesh& mesh, const Reference& reference, const AdviceClock& clock,
                 AdviceRow& row) {
  double had = 1;
  const SessionResult own = run_row(with_own_cells(scene, mesh), clock, had);
  row.rates_error = compare_forces(tick_forces(own.tools[0].frames), reference).force_error;
  const SessionResult result = scene.local.refine == "off" ? own : run_row(Session(scene, mesh), clock, had);
  const double rate_hz = scene.local.rate_hz;
  row.global_ms = had * percentile(result.refresh.global_ms, 0.5);
  row.refresh_ms = had * percentile(result.refresh.refresh_ms, 0.5);
  row.tick_us = percentile(result.step_us, 0.99);
  row.refreshes_per_second =
      static_cast<double>(result.refreshes.size()) * rate_hz / static_cast<double>(result.tools[0].frames.size());
  row.core_share = 1e-6 * percentile(result.step_us, 0.5) * rate_hz +
                   1e-3 * (row.global_ms + row.refresh_ms) * row.refreshes_per_second;
}

}  // namespace

double share_of_core(const std::function<void()>& work) {
  const auto started = std::chrono::steady_clock::now();
  const double cpu_ms = process_time_ms();
  work();
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - started;
  return std::min(1.0, 1e-3 * (process_time_ms() - cpu_ms) / wall.count());
}

Scene row_scene(const Scene& scene, double rate_hz, const std::string& reducer) {
  Scene out = scene;
  out.global.rate_hz = rate_hz;
  out.local.reducer = reducer;
  out.local.integrator = "auto";  // what suits one reducer need not suit another
  if (reducer == "wall") out.local.rings = 1;
  // A model made in another thread is there when it is made.
  return scene.link.type == "lockstep" ? out : as_real_time(std::move(out));
}

void measure_rates(const AdviceScene& scene, int body, const AdviceClock& clock, Advice& out) {
  AdviceBody& judged = out.bodies[body];
  const Scene with = with_body(scene.scene, judged);
  Reference reference;
  std::string why_none;
  if (judged.nodes > kMostNodes) why_none = text("no reference for more than ", kMostNodes, " nodes");
  if (why_none.empty()) try {
      reference = find_reference(scene, with_own_cells(row_scene(with, kRates[0], "condensed"), judged.mesh), clock);
    } catch (const std::runtime_error& e) {
      why_none = text("no reference: ", e.what());
    }
  judged.reference_rate_hz = reference.rate_hz;
  judged.reference_seconds = static_cast<double>(reference.force.size()) * reference.h;
  if (why_none.empty() && judged.reference_seconds < kShortest) why_none = "its reference is beyond the time budget";
  const double own_error = out.truth.why_none.empty() ? judged.error : 0;
  double last = 0;  // that a row took [s]
  for (const char* reducer : kReducers) {
    std::string why_not = why_none;
    for (double rate : kRates) {
      if (rate > with.local.rate_hz) continue;
      AdviceRow row{.body = body, .rate_hz = rate, .reducer = reducer, .note = why_not};
      if (why_not.empty()) try {
          if (clock.is_over() || kMargin * last > clock.left()) throw RunError("beyond the time budget");
          const double started = clock.seconds();
          measure_row(row_scene(with, rate, reducer), judged.mesh, reference, clock, row);
          last = clock.seconds() - started;
          row.error = own_error + row.rates_error;
          if (!is_real_time(candidate_of(row, with.local.rate_hz))) why_not = text("too slow at ", rate, " Hz already");
        } catch (const std::runtime_error& e) {
          row.note = e.what();
        }
      out.rows.push_back(row);
    }
  }
}

}  // namespace kt
