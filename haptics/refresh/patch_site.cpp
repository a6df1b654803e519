#include "haptics/refresh/patch_site.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/shape/closest_point.hpp"
#include "collision/shape/tool_shape.hpp"
#include "core/body/near_triangles.hpp"

namespace kt {
namespace {

/// [m/s] Of a tool with a bound the least of it and this counts; without one, as of a hand, the apron has to do:
/// patches for whatever a hand could do are three times as costly, and come too late for what it does.
double gets_faster(const TouchTool& tool) { return std::isfinite(tool.max_speed) ? 0.1 : 0.03; }

/// Around the place where a large ball touches, or will: as much as a fingertip needs around what it touches now, and
/// no more than some hundred nodes can be followed.
/// @returns [m]
double large_ball_extent(const Surface& surface, const VectorX& x, const Vec3& place, double radius) {
  constexpr double kFingertip = 0.01;  // [m]
  constexpr double kNearly = 5e-4;     // [m] of the ball: touched
  constexpr std::size_t kMost = 100;   // nodes
  std::vector<int> nodes;
  for (int i = 0; i + 1 < static_cast<int>(surface.topology.first.size()); ++i)
    if (!surface.topology.triangles_of(i).empty()) nodes.push_back(i);
  const auto from = [&](const Vec3& p) { return [&x, p](int i) { return (node(x, i) - p).norm(); }; };
  const Vec3 foot = node(x, *std::ranges::min_element(nodes, {}, from(place)));
  double touched = 0;
  for (const int i : nodes)
    if (from(place)(i) <= radius + kNearly) touched = std::max(touched, from(foot)(i));
  double most = std::numeric_limits<double>::infinity();
  if (nodes.size() > kMost && !surface.embedded) {  // where the cells' corners are followed, and not the vertices
    std::ranges::nth_element(nodes, nodes.begin() + kMost, {}, from(foot));
    most = from(foot)(nodes[kMost]);
  }
  return std::max(1.5 * kFingertip, std::min(touched + 0.5 * kFingertip, most));
}

/// As much of the tool's way and of its margin as a patch is worth that is half as large again as without them.
void lead(const Surface& surface, const VectorX& x, const ToolPlace& tool, ContactSite& site) {
  constexpr double kMore = 1.5;  // times as many vertices
  constexpr int kHalvings = 6;
  if (tool.way.isZero(0) && tool.margin <= 0) return;
  const ContactSite at_once = site;
  const double most = kMore * count_patch_vertices(surface, x, site);
  double share = 0, next = 1;
  for (int i = 0; i <= kHalvings; ++i) {
    ContactSite longer = at_once;
    longer.reach += next * tool.margin;
    longer.way = next * tool.way;
    if (count_patch_vertices(surface, x, longer) <= most) {
      share = next;
      site = longer;
      if (share == 1) return;
    }
    next = share + std::ldexp(1.0, -i - 1);
  }
}

}  // namespace

double patch_reach(const Surface& surface, const VectorX& x, const TouchTool& tool, const Vec3& place,
                   const Vec3& velocity, double seconds, double contact_extent) {
  constexpr double kAround = 1.2;  // where it may be off the path; further off the apron catches it
  constexpr double kLeast = 0.75;  // of the tool's reach: a body that swings
  constexpr double kLarge = 0.01;  // [m]
  double around = kAround * tool_reach(tool.shape);
  if (tool.shape.corners.empty() && tool.shape.radius > kLarge)
    around = std::min(around, large_ball_extent(surface, x, place, tool.shape.radius));
  if (contact_extent > 0) around = std::min(around, std::max(contact_extent, kLeast * tool_reach(tool.shape)));
  const double speed = std::min({tool.max_speed, kFollowedSpeed, 1.5 * velocity.norm() + gets_faster(tool)});
  return around + speed * seconds;
}

void expect_late(const TouchTool& tool, const Vec3& velocity, const Vec3& way, double delay, ToolPlace& place) {
  if (!(delay > 0)) return;
  place.way = way;
  place.margin = std::min({tool.max_speed, kFollowedSpeed, 0.5 * velocity.norm() + gets_faster(tool)}) * delay;
}

ContactSite find_contact_site(const Surface& surface, const VectorX& x, const Vec3& tool, int triangle, double reach) {
  ContactSite site{tool, triangle, reach};
  double nearest = std::numeric_limits<double>::infinity();
  const auto consider = [&](int t) {
    const Triangle& v = surface.triangles[t];
    const ClosestPoint at = closest_point_on_triangle(tool, node(x, v[0]), node(x, v[1]), node(x, v[2]));
    if (at.distance_sq < nearest) {
      nearest = at.distance_sq;
      site.centre = at.point;
      site.triangle = t;
    }
  };
  if (triangle >= 0) {
    consider(triangle);
    // Triangles of a scan are smaller than the contact, and the one that is told may be at its rim: down to the nearest
    // one beside it.
    for (int from = -1; surface.embedded && from != site.triangle;) {
      from = site.triangle;
      for (const int v : surface.triangles[from])
        for (const int t : surface.topology.triangles_of(v)) consider(t);
    }
  } else
    for_each_near(surface, x, tool, nearest, consider);
  return site;
}

ContactSite find_contact_sites(const Surface& surface, const VectorX& x, std::span<const ToolPlace> tools) {
  const auto nodes = x.reshaped(3, x.size() / 3);
  const double size = (nodes.rowwise().maxCoeff() - nodes.rowwise().minCoeff()).norm();
  std::vector<ContactSite> sites;
  for (const ToolPlace& tool : tools) {
    sites.push_back(find_contact_site(surface, x, tool.place, tool.triangle, tool.reach));
    lead(surface, x, tool, sites.back());
    // Nearer than the body is large it could be taken for one inside, seen through the body from another tool's patch.
    const bool is_far = (sites.back().centre - tool.place).norm() > std::max(2 * tool.reach, size);
    if (is_far && tool.triangle < 0 && tools.size() > 1) sites.pop_back();
  }
  if (sites.empty()) return find_contact_site(surface, x, tools[0].place, -1, tools[0].reach);
  ContactSite out = sites.front();
  out.others.assign(sites.begin() + 1, sites.end());
  return out;
}

}  // namespace kt
