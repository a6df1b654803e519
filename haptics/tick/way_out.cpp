#include "haptics/tick/way_out.hpp"

#include <algorithm>
#include <numeric>

#include "collision/held/surface_contacts.hpp"
#include "collision/shape/closest_point.hpp"
#include "haptics/tick/contact_check.hpp"

namespace kt {
namespace {

std::vector<Vec3> placed_corners(const ToolShape& tool, const Vec3& place, const Quaternion& turn, int most) {
  if (tool.corners.empty()) return {place};
  std::vector<Vec3> out;
  const std::size_t count = tool.corners.size(), wanted = std::min(count, static_cast<std::size_t>(most));
  for (std::size_t i = 0; i < wanted; ++i) out.push_back(place + turn * tool.corners[i * count / wanted]);
  return out;
}

}  // namespace

WayOutSearch::WayOutSearch(const Surface& surface, int num_nodes, const std::vector<int>& fixed)
    : is_fixed_(static_cast<std::size_t>(num_nodes), 0) {
  whole_.triangles = surface.triangles;
  whole_.topology = surface.topology;
  whole_.global_node.resize(static_cast<std::size_t>(num_nodes));
  std::iota(whole_.global_node.begin(), whole_.global_node.end(), 0);
  for (const int i : fixed) is_fixed_[i] = 1;
}

std::optional<WayOut> WayOutSearch::find(const VectorX& x, const ToolShape& tool, const Vec3& place,
                                         const Quaternion& turn, double least, int most) const {
  const std::vector<Vec3> corners = placed_corners(tool, place, turn, most);
  const auto nodes = x.reshaped(3, x.size() / 3);
  const Vec3 low = nodes.rowwise().minCoeff().array() - tool.radius,
             high = nodes.rowwise().maxCoeff().array() + tool.radius;
  const bool is_inside = std::ranges::any_of(corners, [&](const Vec3& p) {
    return (p.array() >= low.array()).all() && (p.array() <= high.array()).all() &&
           clear_distance(whole_, x, tool, p) < -least;
  });
  if (!is_inside) return {};
  Vec3 centre = Vec3::Zero();
  for (const Vec3& p : corners) centre += p / static_cast<double>(corners.size());
  std::optional<WayOut> out;
  double shortest = std::numeric_limits<double>::infinity();
  for (int t = 0; t < static_cast<int>(whole_.triangles.size()); ++t) {
    const Triangle& v = whole_.triangles[t];
    if (std::ranges::any_of(v, [&](int i) { return is_fixed_[i] != 0; })) continue;
    const Vec3 a = node(x, v[0]), normal = face_normal(whole_, x, t);
    double depth = -std::numeric_limits<double>::infinity();  // below the triangle's plane
    for (const Vec3& p : corners) depth = std::max(depth, tool.radius - normal.dot(p - a));
    // As far as the plane is, and the triangle itself: planes of other parts of the body may be near.
    const double away = std::sqrt(closest_point_on_triangle(centre, a, node(x, v[1]), node(x, v[2])).distance_sq);
    const double way = std::max(depth, away);
    if (!(way < shortest) || !(depth > 0)) continue;
    shortest = way;
    out = WayOut{t, depth};
  }
  return out;
}

}  // namespace kt
