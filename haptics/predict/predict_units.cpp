#include "haptics/predict/predict_units.hpp"

#include <algorithm>
#include <array>

#include "haptics/setup/built_scene.hpp"
#include "io/surface/mesh_doctor.hpp"

namespace kt {
namespace {

constexpr double kSmallest = 0.005, kLargest = 1;  // [m] of a body
constexpr double kSoftest = 100, kStiffest = 1e9;  // [Pa]
constexpr double kDeepest = 0.3;                   // of the thickness

std::string body_line(const Scene& scene, const SceneSizes& s) {
  const double longest = s.body.size().maxCoeff();
  std::string out = text("object.mesh: the body is ", longest, " m long, outside ", kSmallest, " to ", kLargest,
                         " m; one unit of the file is taken as ", s.mesh_unit, " m; ");
  if (scene.object.size) return out + text("set object.size to the body's longest side in metres");
  Bounds file = s.body;
  file.min /= s.mesh_unit;
  file.max /= s.mesh_unit;
  const double scale = likely_scale(file);
  if (scale == s.mesh_unit) return out + "set object.size to its longest side in metres if it is meant to be another";
  return out + text("set object.scale to ", scale, ": its unit is likely ", likely_unit(file), ", or set object.size");
}

/// Along an axis, from the body's outermost surface over the place to the next one below [m]; 0: the line misses it.
double thickness_under(const VectorX& x, const std::vector<Triangle>& triangles, const Vec3& place, int axis) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  std::vector<double> heights;
  for (const Triangle& t : triangles) {
    const Vec3 a = node(x, t[0]), e = node(x, t[1]) - a, f = node(x, t[2]) - a, p = place - a;
    const double area = e[u] * f[v] - e[v] * f[u];
    if (area == 0) continue;
    const double s = (p[u] * f[v] - p[v] * f[u]) / area, r = (e[u] * p[v] - e[v] * p[u]) / area;
    if (s >= 0 && r >= 0 && s + r <= 1) heights.push_back(a[axis] + s * e[axis] + r * f[axis]);
  }
  std::ranges::sort(heights, std::greater<>());
  for (const double h : heights)
    if (heights.front() - h > 1e-9) return heights.front() - h;
  return 0;
}

double extent_of(const ToolShape& tool) {
  Vec3 low = Vec3::Zero(), high = low;
  for (std::size_t i = 0; i < tool.corners.size(); ++i) {
    low = i == 0 ? tool.corners[i] : low.cwiseMin(tool.corners[i]);
    high = i == 0 ? tool.corners[i] : high.cwiseMax(tool.corners[i]);
  }
  return (high - low).maxCoeff() + 2 * tool.radius;
}

SceneSizes sizes_of(const BuiltScene& built) {
  const Scene& scene = built.scene();
  SceneSizes out{.body = bounds(built.model().mesh()), .mesh_unit = built.mesh_unit(), .tool = extent_of(built.tool())};
  if (scene.tool.path.press_drag && built.path().size() > 1) {
    const auto& below = scene.object.fixed.below;
    out.depth = scene.tool.path.press_drag->depth;
    out.thickness = thickness_under(built.start().x, built.surface().triangles, built.path()[1].x,
                                    below ? below->axis[0] - 'x' : 2);
  }
  return out;
}

}  // namespace

std::vector<Prediction> predict_units(const Scene& scene, const SceneSizes& s) {
  std::vector<Prediction> out;
  const auto warn = [&](const std::string& line) { out.push_back({"units", line}); };
  const double longest = s.body.size().maxCoeff(), young = scene.object.model.young;
  if (longest < kSmallest || longest > kLargest) warn(body_line(scene, s));
  if (s.tool > longest)
    warn(text("tool: it is ", 1e3 * s.tool, " mm wide, larger than the body of ", 1e3 * longest,
              " mm; set object.size or object.scale, or tool.radius, in metres"));
  if (s.thickness > 0 && s.depth > kDeepest * s.thickness)
    warn(text("tool.path.press_drag.depth: ", 1e3 * s.depth, " mm is ", s.depth / s.thickness,
              " of the body's thickness there, ", 1e3 * s.thickness, " mm (usual: up to ", kDeepest,
              "); set tool.path.press_drag.depth to ", kDeepest * s.thickness, " or less"));
  if (young < kSoftest || young > kStiffest)
    warn(text("object.model.young: ", young, " Pa is outside ", kSoftest, " to ", kStiffest,
              " Pa (fat 1e3, muscle 1e4, rubber 1e6); set object.model.young in pascal, not kPa or MPa"));
  return out;
}

void predict_units(const BuiltScene& built, std::vector<Prediction>& out) {
  for (Prediction& p : predict_units(built.scene(), sizes_of(built))) out.push_back(std::move(p));
}

}  // namespace kt
