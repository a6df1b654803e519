#include "haptics/predict/predict_units.hpp"

#include <algorithm>
#include <cmath>

#include "haptics/setup/built_scene.hpp"
#include "haptics/setup/tool_unit.hpp"
#include "io/surface/mesh_doctor.hpp"

namespace kt {
namespace {

constexpr double kSmallest = 0.005, kLargest = 1;  // [m] of a body
constexpr double kSoftest = 100, kStiffest = 1e9;  // [Pa]
constexpr double kDeepest = 0.3;                   // of the thickness

Finding body_finding(const Scene& scene, const SceneSizes& s) {
  const double longest = s.body.size().maxCoeff();
  Finding out{told("object.mesh: the body is ", longest, " m long, outside ", kSmallest, " to ", kLargest,
                   " m; one unit of the file is taken as ", s.mesh_unit, " m")};
  out = std::move(out).at("object.mesh", longest, longest < kSmallest ? kSmallest : kLargest);
  Bounds file = s.body;
  file.min /= s.mesh_unit;
  file.max /= s.mesh_unit;
  if (const double scale = likely_scale(file); !scene.object.size && scale != s.mesh_unit)
    out.cures.push_back(
        {"object.scale", text(scale), told("set object.scale to ", scale, ": its unit is likely ", likely_unit(file))});
  out.cures.push_back(advise("set object.size to the body's longest side in metres"));
  return out;
}

/// The setting that a tool's size is read from.
Cure tool_cure(const SceneTool& tool, const std::string& name, double longest, double body) {
  if (tool.shape != "mesh")
    return advise(
        told("set ", name, ".radius", tool.shape == "capsule" ? " and " + name + ".length" : "", " in metres"));
  if (tool.size) return advise(told("set ", name, ".size to its longest side in metres"));
  const double scale = tool.scale.value_or(1);
  return set_to(name + ".scale", likely_tool_unit(longest / scale, body),
                told("one unit of ", tool.mesh, " is taken as ", scale, " m"));
}

Finding tool_finding(const Scene& scene, const SceneTool& tool, const std::string& name, const Vec3& extents,
                     const SceneSizes& s) {
  const double longest = s.body.size().maxCoeff();
  Finding out{told(name, ": it is ", 1e3 * extents[1], " mm wide, larger than the body of ", 1e3 * longest, " mm")};
  out = std::move(out).at(name, extents[1], longest);
  const bool is_usual = longest >= kSmallest && longest <= kLargest;
  if (!is_usual) out.cures = body_finding(scene, s).cures;
  if (is_usual || extents[1] > kLargest) out.cures.push_back(tool_cure(tool, name, extents[2], longest));
  return out;
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

SceneSizes sizes_of(const BuiltScene& built) {
  const Scene& scene = built.scene();
  SceneSizes out{.body = bounds(built.model().mesh()), .mesh_unit = built.mesh_unit(), .tool = sides_of(built.tool())};
  if (scene.second_tool) out.second_tool = sides_of(built.tools()[1]);
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
  const auto warn = [&](Finding found) { out.push_back({"units", std::move(found)}); };
  const double longest = s.body.size().maxCoeff(), young = scene.object.model.young;
  if (longest < kSmallest || longest > kLargest) warn(body_finding(scene, s));
  if (s.tool[1] > longest) warn(tool_finding(scene, scene.tool, "tool", s.tool, s));
  if (scene.second_tool && s.second_tool && (*s.second_tool)[1] > longest)
    warn(tool_finding(scene, *scene.second_tool, "second_tool", *s.second_tool, s));
  if (s.thickness > 0 && s.depth > kDeepest * s.thickness)
    warn(Finding{told("tool.path.press_drag.depth: ", 1e3 * s.depth, " mm is ", s.depth / s.thickness,
                      " of the body's thickness there, ", 1e3 * s.thickness, " mm (usual: up to ", kDeepest, ")"),
                 {{"tool.path.press_drag.depth", text(kDeepest * s.thickness),
                   told("set tool.path.press_drag.depth to ", kDeepest * s.thickness, " or less")}}}
             .at("tool.path.press_drag.depth", s.depth, kDeepest * s.thickness));
  const bool is_read = scene.object.model.type != "msd" || !scene.object.model.stiffness;
  if (is_read && (young < kSoftest || young > kStiffest))
    warn(Finding{told("object.model.young: ", young, " Pa is outside ", kSoftest, " to ", kStiffest,
                      " Pa (fat 1e3, muscle 1e4, rubber 1e6)"),
                 {advise("set object.model.young in pascal, not kPa or MPa")}}
             .at("object.model.young", young, young < kSoftest ? kSoftest : kStiffest));
  return out;
}

void predict_units(const BuiltScene& built, std::vector<Prediction>& out) {
  for (Prediction& p : predict_units(built.scene(), sizes_of(built))) out.push_back(std::move(p));
}

}  // namespace kt
