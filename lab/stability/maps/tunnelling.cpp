// Tool speed x thickness of a sheet: which methods let a small ball through. Those that follow the tool along its way
// (continuous collision detection) should at no speed; those that look once a tick, or once a refresh, where the tool
// has gone past the ball's own size meanwhile: v h = 2 r.
#include <algorithm>
#include <cmath>

#include "collision/shape/closest_point.hpp"
#include "core/base/numbers.hpp"
#include "core/base/parallel.hpp"
#include "lab/stability/bisect.hpp"
#include "lab/stability/runs/rays.hpp"
#include "lab/stability/runs/session_runs.hpp"
#include "lab/stability/runs/single_points.hpp"

namespace kt {
namespace {

constexpr double kRadius = 0.001;  // [m]
constexpr double kEdge = 0.005;    // of the sheet's squares [m]
constexpr int kCells = 6;
constexpr double kSlowest = 0.05, kFastest = 10;  // [m/s] no hand is faster

/// 30 x 30 mm, one layer of cells, its top at z = 0.
Mesh sheet_mesh(double thickness) {
  Mesh out = kuhn_block(kCells, kCells, 1, kEdge);
  for (int i = 0; i < out.num_nodes(); ++i) node(out.x, i).z() *= thickness / kEdge;
  for (int i = 0; i < out.num_nodes(); ++i) node(out.x, i).z() -= thickness;
  return out;
}

std::vector<int> border_nodes(const Mesh& mesh) {
  const Bounds box = bounds(mesh);
  std::vector<int> out;
  for (int i = 0; i < mesh.num_nodes(); ++i) {
    const Vec3 p = node(mesh.x, i);
    if (p.x() < box.min.x() + 1e-6 || p.x() > box.max.x() - 1e-6 || p.y() < box.min.y() + 1e-6 ||
        p.y() > box.max.y() - 1e-6)
      out.push_back(i);
  }
  return out;
}

/// Straight down at that speed, until the ball would be a little below the sheet; then it stays.
/// @param phase  share of a tick by which the flight starts later
Scene shot(const std::string& method, double speed, double thickness, const Mesh& mesh, double phase) {
  constexpr double kRest = 0.02, kHold = 0.2;  // [s] before and after
  const double end = -thickness - 1.5 * kRadius, start = kRadius + 0.002 + 1e-3 * speed;
  const double from = kRest + 1e-3 * phase, to = from + (start - end) / speed;
  const Vec3 over(0.0161, 0.0143, 0);
  Scene scene = slab_scene();
  scene.title = "sheet";
  scene.duration = 1e-3 * std::ceil(1e3 * (to + kHold));
  scene.object.fixed = {.below = {}, .box = {}, .nodes = border_nodes(mesh)};
  scene.tool.radius = kRadius;
  scene.tool.path = {.press_drag = {}, .waypoints = {}, .recording = {}, .hand = {}, .device = {}};
  scene.tool.path.waypoints = std::vector<Waypoint>{{0, over + start * Vec3::UnitZ()},
                                                    {from, over + start * Vec3::UnitZ()},
                                                    {to, over + end * Vec3::UnitZ()},
                                                    {to + kHold, over + end * Vec3::UnitZ()}};
  scene.local.method = method;
  if (method == "legacy") scene.local.reducer = "wall";
  return scene;
}

/// The ball lies nearer to the sheet's underside than to its top, which may be away from it: a light sheet flies on.
bool is_below(const Mesh& sheet, const Snapshot& end) {
  double nearest = std::numeric_limits<double>::infinity();
  bool is_underside = false;
  for (const Triangle& t : sheet.triangles) {
    const double distance_sq =
        closest_point_on_triangle(end.tools[0], node(end.x, t[0]), node(end.x, t[1]), node(end.x, t[2])).distance_sq;
    if (distance_sq >= nearest) continue;
    nearest = distance_sq;
    const Vec3 a = node(sheet.x, t[0]);
    is_underside = (node(sheet.x, t[1]) - a).cross(Vec3(node(sheet.x, t[2]) - a)).z() < 0;
  }
  return is_underside;
}

}  // namespace

/// Of several phases within a tick the worst: a check once a tick may be lucky.
MapPoint shoot_at_sheet(const std::string& method, double speed, double thickness, const MapOptions& options) {
  const Mesh mesh = sheet_mesh(thickness);
  MapPoint out;
  for (double phase : {0.0, 0.37, 0.71}) {
    const SessionRun run = run_session("tunnelling", shot(method, speed, thickness, mesh, phase), mesh, options);
    MapPoint p = point_of(method, speed, thickness, run);
    if (run.result.stopped) return p;
    const auto& frames = run.result.tools[0].frames;
    const bool is_through = !run.result.snapshots.empty() && is_below(mesh, run.result.snapshots.back());
    p.why = failure_of(run);
    p.verdict = p.why.empty() && !is_through ? MapVerdict::works : MapVerdict::fails;
    if (is_through)
      p.why = run.force.ticks_free == static_cast<int>(frames.size()) ? "went through unseen"
                                                                      : "was felt, and went through";
    if (p.verdict == MapVerdict::works) p.why = text("held, at most ", in_unit(run.deepest, "m"), " inside");
    p.value = run.deepest;
    if (p.verdict == MapVerdict::works && run.deepest > 0.5 * std::min(thickness, kRadius))
      p.verdict = MapVerdict::degrades;
    if (phase == 0 || p.verdict > out.verdict) out = p;
    if (out.verdict == MapVerdict::fails) break;
  }
  return out;
}

namespace {

RayResult trace(const std::string& method, double thickness, const MapOptions& options) {
  RayResult out;
  const auto fails = [&](double speed) {
    out.points.push_back(shoot_at_sheet(method, speed, thickness, options));
    return out.points.back().verdict == MapVerdict::fails;
  };
  double good = 0, bad = 0;
  for (double v : {kSlowest, 0.5, 5.0, kFastest}) {
    if (fails(v)) {
      bad = v;
      break;
    }
    good = v;
  }
  if (bad > 0 && bad < kFastest) fails(kFastest);
  if (good > 0 && bad > 0) {
    const RayCrossing limit = bisect(good, bad, {.tolerance = options.full ? 0.05 : 0.2}, fails);
    out.boundaries.push_back({method, "the ball gets through, measured", {{limit.at(), thickness}}, false});
  }
  return out;
}

}  // namespace

StabilityMap map_tunnelling(const MapOptions& options) {
  StabilityMap map;
  map.x_name = "tool speed v [m/s]";
  map.y_name = "thickness of the sheet [m]";
  map.x_log = map.y_log = true;
  const std::vector<std::string> methods{"multirate", "hold", "penalty", "frozen", "legacy"};
  const std::vector<double> thicknesses = options.full ? std::vector<double>{0.0005, 0.001, 0.002, 0.004, 0.008}
                                                       : std::vector<double>{0.0005, 0.002, 0.008};
  const int n = static_cast<int>(thicknesses.size());
  with_threads(1, [&] {
    run_rays(
        options, n * static_cast<int>(methods.size()),
        [&](int i) { return trace(methods[i / n], thicknesses[i % n], options); }, map);
  });
  for (const char* once_a_tick : {"penalty", "frozen"}) {
    map.boundaries.push_back({once_a_tick, "theory: v h = 2 r, h = 1 ms", {}, true});
    for (double t : thicknesses) map.boundaries.back().points.push_back({2 * kRadius / 1e-3, t});
  }
  const auto through = std::ranges::count_if(
      map.points, [](const MapPoint& p) { return p.series == "multirate" && p.verdict == MapVerdict::fails; });
  map.claim = told("multirate lets the ball through in ", through, " runs up to ", kFastest,
                   " m/s; frozen and penalty do above 2 r in a tick, ", 2 * kRadius / 1e-3, " m/s");
  return map;
}

}  // namespace kt
