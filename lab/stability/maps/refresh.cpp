// Latency x loss of the link x rate of the body: how far the force on a short drag goes off that of the same scene
// whose local models arrive at once, and from where on the contact leaves the patch that it has.
#include <algorithm>
#include <cmath>

#include "core/base/numbers.hpp"
#include "core/base/parallel.hpp"
#include "lab/stability/bisect.hpp"
#include "lab/stability/runs/rays.hpp"
#include "lab/stability/runs/session_runs.hpp"
#include "lab/stability/runs/single_points.hpp"
#include "lab/study/reference.hpp"

namespace kt {
namespace {

constexpr double kJnd = 0.1;
constexpr double kEdge = 0.005;
constexpr double kLongest = 500;  // [ms]

Scene drag(double rate_hz, double latency_ms, double loss) {
  Scene scene = slab_scene();
  scene.duration = 0.5;
  scene.global.rate_hz = rate_hz;
  scene.link.latency_ms = latency_ms;
  scene.link.loss = loss;
  return scene;
}

struct Row {
  double rate_hz;
  std::string name() const { return text(rate_hz, " Hz"); }
};

std::vector<Vec3> forces_in_time(double rate_hz, const Mesh& mesh, const MapOptions& options) {
  return tick_forces(run_session("refresh", drag(rate_hz, 0, 0), mesh, options).result.tools[0].frames);
}

/// With what arrives at once for the truth.
MapPoint judge(const Row& row, double latency_ms, double loss, const std::vector<Vec3>& best, const Mesh& mesh,
               const MapOptions& options) {
  const SessionRun run = run_session("refresh", drag(row.rate_hz, latency_ms, loss), mesh, options);
  MapPoint p = point_of(row.name(), latency_ms, loss, run);
  if (run.result.stopped) return p;
  Reference truth;
  truth.h = 1e-3;
  truth.force = best;
  p.value = compare_forces(tick_forces(run.result.tools[0].frames), truth).force_error;
  p.why = failure_of(run);
  if (p.why.empty() && run.force.lost_contacts > 0) p.why = text("contact lost ", run.force.lost_contacts, " times");
  if (p.why.empty() && run.result.tools[0].missed_impacts > 0)
    p.why = text("inside without contact in ", run.result.tools[0].missed_impacts, " ticks");
  if (!p.why.empty()) {
    p.verdict = MapVerdict::fails;
    return p;
  }
  const auto off = std::ranges::count_if(run.result.tools[0].frames,
                                         [](const LocalFrame& f) { return (f.flags & kLeftPatch) != 0; });
  p.why = told("force off by ", in_percent(p.value), ", buzz ", in_percent(run.force.buzz), ", jump at refreshes ",
               in_percent(run.force.refresh_jump), ", at the patch's edge in ", off, " ticks");
  p.verdict = p.value > kJnd || run.force.buzz > kJnd || off > 0 ? MapVerdict::degrades : MapVerdict::works;
  return p;
}

RayResult trace(const Row& row, double loss, const Mesh& mesh, const MapOptions& options) {
  RayResult out;
  const std::vector<Vec3> forces = forces_in_time(row.rate_hz, mesh, options);
  const auto is = [&](MapVerdict least) {
    return [&, least](double latency) {
      for (const MapPoint& p : out.points)
        if (p.x == latency) return p.verdict >= least;
      out.points.push_back(judge(row, latency, loss, forces, mesh, options));
      return out.points.back().verdict >= least;
    };
  };
  const double tolerance = options.full ? 0.05 : 0.4;
  for (double latency : {1.0, 10.0, 100.0, kLongest}) is(MapVerdict::fails)(latency);
  const auto limit = [&](MapVerdict least, const char* label) {
    double good = 0, bad = 0;
    for (const MapPoint& p : out.points) {
      if (p.verdict >= least) {
        bad = p.x;
        break;
      }
      good = p.x;
    }
    if (good == 0 || bad == 0) return;
    const RayCrossing found = bisect(good, bad, {.tolerance = tolerance}, is(least));
    out.boundaries.push_back({row.name(), label, {{found.at(), loss}}, false});
  };
  limit(MapVerdict::degrades, "off by more than 10 %, measured");
  std::ranges::sort(out.points, {}, &MapPoint::x);
  limit(MapVerdict::fails, "contact lost, measured");
  return out;
}

}  // namespace

MapPoint drag_with_late_models(double rate_hz, double latency_ms, double loss, const MapOptions& options) {
  const Mesh mesh = slab_mesh(kEdge);
  return judge({rate_hz}, latency_ms, loss, forces_in_time(rate_hz, mesh, options), mesh, options);
}

StabilityMap map_refresh(const MapOptions& options) {
  StabilityMap map;
  map.x_name = "latency of the link [ms]";
  map.y_name = "share of local models lost";
  map.x_log = true;
  const std::vector<Row> rows{{10}, {30}, {60}};
  const std::vector<double> losses =
      options.full ? std::vector<double>{0, 0.1, 0.2, 0.4, 0.6, 0.8, 0.9} : std::vector<double>{0, 0.3, 0.6, 0.9};
  const int n = static_cast<int>(losses.size());
  const Mesh mesh = slab_mesh(kEdge);
  with_threads(1, [&] {
    run_rays(
        options, n * static_cast<int>(rows.size()),
        [&](int i) { return trace(rows[i / n], losses[i % n], mesh, options); }, map);
  });
  double latest = 0;
  for (const MapPoint& p : map.points)
    if (p.y == 0 && p.verdict == MapVerdict::works) latest = std::max(latest, p.x);
  const Confusion c = count_predictions(map.points);
  map.claim = told("without loss the force stays within ", in_percent(kJnd), " of its run without latency up to ",
                   latest, " ms; no contact is lost at any latency up to ", kLongest, " ms: ", c.failures, " of ",
                   c.points, " runs fail");
  return map;
}

}  // namespace kt
