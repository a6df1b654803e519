#include "haptics/predict/predict_degenerate_contact.hpp"

#include <algorithm>

#include "core/base/types.hpp"
#include "haptics/refresh/refresher.hpp"
#include "haptics/setup/built_scene.hpp"
#include "haptics/tick/contact_check.hpp"
#include "haptics/tick/way_out.hpp"

namespace kt {
namespace {

/// Height over its longest edge, relative to that edge.
double flatness(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double longest_sq = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  return longest_sq > 0 ? (b - a).cross(c - a).norm() / longest_sq : 0;
}

}  // namespace

std::optional<Prediction> predict_flat_triangles(const VectorX& x, const std::vector<Triangle>& triangles) {
  constexpr double kFlat = 1e-9;  // of its edge: below, the normal is mostly roundoff
  const auto is_flat = [&](const Triangle& t) { return flatness(node(x, t[0]), node(x, t[1]), node(x, t[2])) < kFlat; };
  const auto first = std::ranges::find_if(triangles, is_flat);
  if (first == triangles.end()) return {};
  const Vec3 at = node(x, (*first)[0]);
  return Prediction{"degenerate_contact",
                    Finding{told("object.mesh: ", std::ranges::count_if(triangles, is_flat),
                                 " surface triangles have no area, the first at (", at.x(), ", ", at.y(), ", ", at.z(),
                                 "): they have no normal, and a point tool may pass them unseen"),
                            {set_to("object.repair", "true")}}
                        .at("object.mesh")};
}

std::optional<Prediction> predict_start_inside(double depth, const std::optional<Vec3>& way_out, bool touches_at_once,
                                               const std::string& key) {
  constexpr double kRoundoff = 1e-7;  // [m] as contact_check counts
  if (!(depth > kRoundoff)) return {};
  Finding out{told(key, ": the tool starts ", 1e3 * depth, " mm inside the body"),
              {advise("start it outside"), advise("move the path's first point out by that much")},
              Finding::Weight::doubt,
              key,
              depth,
              0};
  if (way_out)
    out.what += told(": the body is pushed off it, out by (", way_out->x(), ", ", way_out->y(), ", ", way_out->z(),
                     ") m, the nearest surface that is not clamped, in 60 ms or at 0.1 m/s; the force is not to be "
                     "trusted before, and grows slowly");
  else
    out.what += touches_at_once ? ": this method takes it as touching there, at any depth"
                                : ", where no contact is looked for before it has been outside";
  return Prediction{"degenerate_contact", std::move(out)};
}

namespace {

/// Where a tool is before its first tick; none of one that a device decides.
std::optional<Pose> start_of(const BuiltScene& built, std::size_t k) {
  const SceneTool& tool = k == 0 ? built.scene().tool : *built.scene().second_tool;
  const ToolPath& path = built.paths()[k];
  if (tool.path.device) return {};
  if (!path.poses.empty()) return path.poses.front().pose;
  if (path.points.empty()) return {};
  return Pose{path.points.front().x, rotation(tool.turn)};
}

std::optional<Prediction> predict_start(const BuiltScene& built, std::size_t k) {
  const std::optional<Pose> start = start_of(built, k);
  if (!start) return {};
  const ToolShape& tool = built.tools()[k];
  const WayOutSearch search(built.surface(), built.model().mesh().num_nodes(), still_nodes(built.model()));
  const VectorX& x = built.start().x;
  const double depth = penetration_depth(search.whole(), x, tool, start->x, start->r);
  // Of the other methods penalty and frozen find no contact there, and legacy does at once.
  const Scene& scene = built.scene();
  const std::string& method = scene.local.method;
  const std::string key = k == 0 ? "tool.path" : "second_tool.path";
  const bool is_pushed = (method == "multirate" || method == "hold") && !is_geometric(scene.contact.law);
  if (!is_pushed) return predict_start_inside(depth, {}, method == "legacy", key);
  const auto way = search.find(x, tool, start->x, start->r, 0, static_cast<int>(tool.corners.size()));
  if (!way) return predict_start_inside(depth, {}, false, key);
  const Triangle& t = built.surface().triangles[way->triangle];
  return predict_start_inside(depth, (node(x, t[0]) + node(x, t[1]) + node(x, t[2])) / 3, false, key);
}

}  // namespace

void predict_degenerate_contact(const BuiltScene& built, std::vector<Prediction>& out) {
  // A ball touches the triangles beside them too: none of the map's was lost.
  const bool is_point = built.tool().kind == ToolShape::Kind::point;
  if (auto p = predict_flat_triangles(built.start().x, built.surface().triangles); p && is_point)
    out.push_back(std::move(*p));
  for (std::size_t k = 0; k < built.tools().size(); ++k)
    if (auto p = predict_start(built, k)) out.push_back(std::move(*p));
}

}  // namespace kt
