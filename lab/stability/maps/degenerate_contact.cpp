// Grazing angle x distance from a feature: drops and grazes exactly on vertices and edges, onto triangles without area,
// and tools that begin inside the body. Whole sessions: contact must be found, nothing passed, every force finite.
#include <cmath>
#include <numbers>

#include "core/base/numbers.hpp"
#include "haptics/findings/run_findings.hpp"
#include "haptics/session/metrics.hpp"
#include "haptics/session/session.hpp"
#include "lab/stability/map.hpp"
#include "lab/stability/runs/rays.hpp"

namespace kt {
namespace {

constexpr double kCell = 0.01;            // [m]
constexpr double kExact = 1e-18;          // [m] drawn for a distance of zero
constexpr double kRadius = 0.004;         // [m] of the sphere
constexpr double kDeepestAllowed = 1e-5;  // [m] of the tool in the deformed surface

enum class Feature { vertex, edge, zero_area, inside };

struct Case {
  Feature feature = Feature::vertex;
  std::string shape;
  std::string series() const {
    switch (feature) {
      case Feature::vertex:
        return "onto a vertex | " + shape;
      case Feature::edge:
        return "along an edge | " + shape;
      case Feature::zero_area:
        return "triangle without area | " + shape;
      case Feature::inside:
        return "inside at start | " + shape;
    }
    return {};
  }
};

/// 5 x 5 x 3 cubes of springs and tetrahedra; the top is at z = 30 mm.
Mesh block() { return kuhn_block(5, 5, 3, kCell); }

constexpr double kTop = 3 * kCell;
const Vec3 kVertex(2 * kCell, 2 * kCell, kTop);        // of the top, inside it
const Vec3 kEdge = kVertex + Vec3(0.5 * kCell, 0, 0);  // middle of the edge from there along x

/// The block with a node on the middle of that edge, which only one of the two triangles beside it takes in: between
/// that triangle's halves and the other one lies a triangle without area.
Mesh with_zero_area(Mesh mesh) {
  const auto at = [&](const Vec3& p) {
    for (int i = 0; i < mesh.num_nodes(); ++i)
      if ((node(mesh.x, i) - p).norm() < 1e-9) return i;
    return -1;
  };
  const int a = at(kVertex), b = at(kVertex + Vec3(kCell, 0, 0)), m = mesh.num_nodes();
  mesh.x.conservativeResize(mesh.x.size() + 3);
  node(mesh.x, m) = kEdge;
  const auto has = [](const auto& element, int i) { return std::ranges::find(element, i) != element.end(); };
  const auto put = [](auto element, int from, int to) {
    std::ranges::replace(element, from, to);
    return element;
  };
  bool done = false;  // of the two triangles beside the edge the first is split
  std::vector<Triangle> triangles;
  for (const Triangle& t : mesh.triangles) {
    if (done || !has(t, a) || !has(t, b)) {
      triangles.push_back(t);
      continue;
    }
    done = true;
    triangles.push_back(put(t, b, m));
    triangles.push_back(put(t, a, m));
    const bool forward = t[(std::ranges::find(t, a) - t.begin() + 1) % 3] == b;
    triangles.push_back(forward ? Triangle{a, b, m} : Triangle{b, a, m});
  }
  mesh.triangles = triangles;
  std::vector<Tetrahedron> tetrahedra;
  for (const Tetrahedron& t : mesh.tetrahedra) {
    if (!has(t, a) || !has(t, b)) {
      tetrahedra.push_back(t);
      continue;
    }
    tetrahedra.push_back(put(t, b, m));
    tetrahedra.push_back(put(t, a, m));
  }
  mesh.tetrahedra = tetrahedra;
  return mesh;
}

Scene scene_of(const Case& c, double angle, double distance) {
  Scene scene = default_scene();
  scene.local.refine = std::string("off");  // the triangles are the case
  scene.duration = 0.2;
  scene.object.mesh = "block";
  scene.object.model.damping = {5, 2e-3};
  scene.tool.shape = c.shape;
  scene.tool.radius = kRadius;
  scene.local.reducer = "condensed";
  scene.tool.path.press_drag.reset();
  const double clear = c.shape == "point" ? 0 : kRadius;  // from the tool's reference point to its surface
  if (c.feature == Feature::inside) {  // it stays where it begins, `distance` below the surface, and then goes out
    const Vec3 start = Vec3(2.3 * kCell, 2.4 * kCell, kTop + clear - distance);
    scene.tool.path.waypoints = {{0, start}, {0.1, start}, {0.2, start + Vec3(0, 0, distance + 0.005)}};
    return scene;
  }
  const double a = angle * std::numbers::pi / 180;
  const Vec3 target = (c.feature == Feature::vertex ? kVertex : kEdge) + Vec3(0, distance, clear);
  const Vec3 way = (Vec3(std::cos(a), 0, -std::sin(a)) * 0.004);
  const Vec3 along = c.feature == Feature::vertex ? Vec3(way.x() * 0.8, way.x() * 0.6, way.z()) : way;
  scene.tool.path.waypoints = {{0, target - along}, {0.2, target + along}};
  return scene;
}

/// A word for everything that a reader of the run would have seen.
std::string loudness(const Session& session, const SessionResult& result) {
  unsigned flags = 0;
  for (const LocalFrame& f : result.tools[0].frames) flags |= f.flags;
  std::string out = flags ? text("flags ", flags) : "";
  for (const std::string& w : lines(all_findings(session, result))) out += (out.empty() ? "" : "; ") + w;
  return out.empty() ? "silent" : out;
}

MapPoint run_case(const Case& c, double angle, double distance) {
  MapPoint p = point_at(c.series(), angle, std::max(distance, kExact));
  try {
    Session session(scene_of(c, angle, distance), c.feature == Feature::zero_area ? with_zero_area(block()) : block());
    for (const Prediction& prediction : session.predictions()) {
      if (prediction.failure != "degenerate_contact") continue;
      p.predicted_failure = true;
      p.prediction = prediction.message();
    }
    const SessionResult result = session.run();
    const ForceMetrics forces = measure_forces(result.tools[0].frames, 0, 1e-3);
    double deepest = 0, largest = 0;
    bool finite = true;
    int touching = 0;
    for (const LocalFrame& f : result.tools[0].frames) {
      finite = finite && f.force.allFinite() && !(f.flags & kNotFinite);
      largest = std::max(largest, f.force.norm());
      touching += f.mode != ContactMode::free;
    }
    for (double d : result.tools[0].penetration) deepest = std::max(deepest, d);
    const double depth = c.feature == Feature::inside ? distance : 0.004 * std::sin(angle * std::numbers::pi / 180);
    const bool is_expected = depth > 1e-7;  // else it may touch or not: it ends on the surface, to rounding
    const bool found = touching > 0 || !is_expected;
    p.value = deepest;
    p.hash = result.hash;
    p.verdict = !finite || !found || result.tools[0].missed_impacts > 0 || deepest > kDeepestAllowed ? MapVerdict::fails
                : forces.lost_contacts > 0 ? MapVerdict::degrades
                                           : MapVerdict::works;
    p.why = told(touching, " ticks in contact, largest force ", largest, " N, deepest ", in_unit(deepest, "m"), ", ",
                 result.tools[0].missed_impacts, " missed, ", forces.lost_contacts, " lost, ",
                 finite ? "finite" : "not finite", "; ", loudness(session, result));
  } catch (const InputError& e) {  // refused before the run
    p.verdict = MapVerdict::fails;
    p.predicted_failure = true;
    p.prediction = p.why = e.what();
  } catch (const RunError& e) {
    p.verdict = MapVerdict::fails;
    p.why = e.what();
  }
  return p;
}

}  // namespace

StabilityMap map_degenerate_contact(const MapOptions& options) {
  StabilityMap map;
  map.x_name = "angle between path and surface [degrees]";
  map.y_name = "distance from the feature, or depth inside at start [m]; exact: drawn at 1e-18";
  map.x_log = map.y_log = true;
  const std::vector<double> angles = options.full ? std::vector<double>{0.001, 0.01, 0.1, 1, 3, 10, 30, 60, 90}
                                                  : std::vector<double>{0.01, 0.1, 1, 10, 90};
  const std::vector<double> offsets{0, 1e-17, 1e-14, 1e-10, 1e-6, 1e-3};
  const std::vector<double> depths{0, 1e-12, 1e-9, 1e-7, 1e-6, 1e-5, 1e-4, 5e-4, 1e-3, 2e-3, 4e-3, 8e-3};
  struct Run {
    Case c;
    double angle, distance;
  };
  std::vector<Run> runs;
  for (Feature feature : {Feature::vertex, Feature::edge, Feature::zero_area, Feature::inside})
    for (const char* shape : {"point", "sphere"}) {
      if (feature == Feature::inside)
        for (double depth : depths) runs.push_back({{feature, shape}, 90, depth});
      else
        for (double angle : angles)
          for (double offset : offsets) runs.push_back({{feature, shape}, angle, offset});
    }
  run_rays(
      options, static_cast<int>(runs.size()),
      [&](int i) {
        const Run& r = runs[static_cast<std::size_t>(i)];
        return RayResult{{run_case(r.c, r.angle, r.distance)}, {}};
      },
      map);
  const Confusion c = count_predictions(map.points);
  map.claim = told(c.working + c.degraded, " of ", c.points,
                   " degenerate contacts are found, with finite forces and "
                   "without passing a surface; ",
                   c.failures, " fail");
  return map;
}

}  // namespace kt
