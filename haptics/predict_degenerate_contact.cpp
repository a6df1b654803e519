#include "haptics/predict_degenerate_contact.hpp"

#include <algorithm>
#include <numeric>

#include "haptics/contact_check.hpp"
#include "haptics/session.hpp"
#include "haptics/tool_turn.hpp"

namespace kt {
namespace {

/// Height over its longest edge, relative to that edge.
double flatness(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double longest_sq = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  return longest_sq > 0 ? (b - a).cross(c - a).norm() / longest_sq : 0;
}

/// Depth of the tool's deepest point at the start [m].
double start_depth(const Session& session) {
  if (session.path().empty()) return 0;
  SurfacePatch whole;
  whole.triangles = session.surface().triangles;
  whole.topology = session.surface().topology;
  whole.global_node.resize(static_cast<std::size_t>(session.model().mesh().num_nodes()));
  std::iota(whole.global_node.begin(), whole.global_node.end(), 0);
  return penetration_depth(whole, session.start().x, session.tool(), session.path().front().x,
                           rotation(session.scene().tool.turn));
}

}  // namespace

std::optional<Prediction> predict_flat_triangles(const VectorX& x, const std::vector<Triangle>& triangles) {
  constexpr double kFlat = 1e-9;  // of its edge: below, the normal is mostly roundoff
  const auto is_flat = [&](const Triangle& t) { return flatness(node(x, t[0]), node(x, t[1]), node(x, t[2])) < kFlat; };
  const auto first = std::ranges::find_if(triangles, is_flat);
  if (first == triangles.end()) return {};
  const Vec3 at = node(x, (*first)[0]);
  return Prediction{"degenerate_contact",
                    text("object.mesh: ", std::ranges::count_if(triangles, is_flat),
                         " surface triangles have no area, the first at (", at.x(), ", ", at.y(), ", ", at.z(),
                         "): they have no normal, and a point tool may pass them unseen; set object.repair to true")};
}

std::optional<Prediction> predict_start_inside(double depth) {
  constexpr double kRoundoff = 1e-7;  // [m] as contact_check counts
  if (!(depth > kRoundoff)) return {};
  return Prediction{"degenerate_contact",
                    text("tool.path: the tool starts ", 1e3 * depth,
                         " mm inside the body, where no contact is looked for before it has been outside; start it "
                         "outside, or raise the path's first point by that much")};
}

void predict_degenerate_contact(const Session& session, std::vector<Prediction>& out) {
  // A ball touches the triangles beside them too: none of the map's was lost.
  const bool is_point = session.tool().kind == ToolShape::Kind::point;
  if (auto p = predict_flat_triangles(session.start().x, session.surface().triangles); p && is_point)
    out.push_back(std::move(*p));
  if (auto p = predict_start_inside(start_depth(session))) out.push_back(std::move(*p));
}

}  // namespace kt
