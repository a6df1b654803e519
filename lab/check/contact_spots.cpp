#include "lab/check/contact_spots.hpp"

#include <algorithm>
#include <cmath>

namespace kt {
namespace {

constexpr double kTouching = 0.01;  // of the radius: overlap elsewhere that does not count
constexpr double kThick = 6;        // depths that the body must be thick
constexpr double kStep = 5e-4;      // of a walk [m]
constexpr double kSharpest = 0.25;  // [rad] that the normal may turn in a step
constexpr double kFurthest = 1.0;   // [rad] and in all

Vec3 normal_of(const SurfaceQuery& surface, int t) {
  const Triangle& v = surface.triangles()[static_cast<std::size_t>(t)];
  const Vec3 a = node(surface.x(), v[0]), b = node(surface.x(), v[1]), c = node(surface.x(), v[2]);
  return (b - a).cross(c - a).normalized();
}

/// How thick the body is below a place: to the next crossing inward.
double thickness_below(const SurfaceQuery& surface, const Vec3& place, const Vec3& normal, double longest) {
  const Vec3 end = place - longest * normal;
  const auto hit = surface.crossing(place, end, 1e-7);
  return hit ? hit->share * longest : longest;
}

std::optional<ContactSpot> spot_at(const SurfaceQuery& surface, const Mesh& body, const HeldTriangles& held, int t,
                                   double radius, const SpotOptions& o) {
  const Triangle& v = body.triangles[static_cast<std::size_t>(t)];
  ContactSpot out;
  out.place = (node(body.x, v[0]) + node(body.x, v[1]) + node(body.x, v[2])) / 3;
  out.normal = normal_of(surface, t);
  out.triangle = t;
  out.radius = radius;
  if (!(out.normal.norm() > 0.5) || held.is_near(out.place, radius)) return {};
  for (const double above : {0.0, 0.5 * kClearance, kClearance})
    if (surface.is_within(out.place + (radius + above) * out.normal, (1 - kTouching) * radius)) return {};
  out.thickness = o.shell > 0 ? o.shell : thickness_below(surface, out.place, out.normal, 0.2);
  out.depth = std::min({o.depth, 0.5 * radius, o.shell > 0 ? o.shell : out.thickness / kThick});
  if (out.depth < 1e-6) return {};  // nothing below to press into
  return out;
}

}  // namespace

HeldTriangles::HeldTriangles(const Mesh& body, std::span<const int> held) {
  std::vector<char> is_held(static_cast<std::size_t>(body.num_nodes()), 0);
  for (const int i : held) is_held[static_cast<std::size_t>(i)] = 1;
  for (const Triangle& t : body.triangles)
    if (std::ranges::any_of(t, [&](int i) { return is_held[static_cast<std::size_t>(i)] != 0; }))
      triangles_.push_back(t);
  if (!triangles_.empty()) near_.emplace(triangles_, body.x);
}

std::vector<ContactSpot> find_contact_spots(const Mesh& body, std::span<const int> held, const SpotOptions& options) {
  const SurfaceQuery surface(body.triangles, body.x);
  const HeldTriangles held_triangles(body, held);
  std::vector<ContactSpot> all;
  const auto triangles = static_cast<int>(body.triangles.size());
  const int stride = std::max(1, triangles / options.tried);
  for (double radius = options.radius; all.empty() && radius > 0.2 * options.radius; radius /= 2)
    for (int t = 0; t < triangles; t += stride)
      if (const auto spot = spot_at(surface, body, held_triangles, t, radius, options)) all.push_back(*spot);
  if (all.empty()) return {};

  // Thin places stay in only where there are no others: a library's average mesh is touched where it is a body.
  const auto is_thick = [&](const ContactSpot& s) { return s.depth > 0.25 * options.depth; };
  if (std::ranges::count_if(all, is_thick) >= options.count) std::erase_if(all, [&](auto& s) { return !is_thick(s); });

  // Each next one as far as can be from those chosen, the first on top.
  std::vector<ContactSpot> out;
  std::vector<double> distance(all.size(), std::numeric_limits<double>::infinity());
  auto next = static_cast<std::size_t>(
      std::ranges::max_element(all, {}, [](const ContactSpot& s) { return s.place.z(); }) - all.begin());
  while (static_cast<int>(out.size()) < std::min<int>(options.count, static_cast<int>(all.size()))) {
    out.push_back(all[next]);
    for (std::size_t i = 0; i < all.size(); ++i)
      distance[i] = std::min(distance[i], (all[i].place - out.back().place).norm());
    next = static_cast<std::size_t>(std::ranges::max_element(distance) - distance.begin());
    if (distance[next] <= 0) break;
  }
  return out;
}

std::vector<Vec3> surface_walk(const SurfaceQuery& surface, const HeldTriangles& held, const ContactSpot& spot,
                               double angle, double length) {
  const double off = spot.radius - spot.depth;
  const Vec3 any = std::abs(spot.normal.x()) < 0.8 ? Vec3::UnitX() : Vec3::UnitY();
  Vec3 normal = spot.normal, at = spot.place + off * normal;
  Vec3 heading = Eigen::AngleAxisd(angle, normal) * (any - any.dot(normal) * normal).normalized();
  std::vector<Vec3> out{at};
  for (double gone = 0; gone < length; gone += kStep) {
    Vec3 next = at + kStep * heading, next_normal = normal;
    NearestPlace near;
    for (int i = 0; i < 20; ++i) {  // to the distance that it keeps
      near = surface.nearest(next, spot.radius);
      const double distance = std::sqrt(near.at.distance_sq);
      if (!(distance > 1e-9)) return out;
      next_normal = (next - near.at.point) / distance;
      next += (off - distance) * next_normal;
      if (std::abs(off - distance) < 1e-4 * spot.depth) break;
    }
    const double turn = std::acos(std::clamp(next_normal.dot(normal), -1.0, 1.0));
    if (turn > kSharpest || next_normal.dot(spot.normal) < std::cos(kFurthest)) break;
    if ((next - at).norm() < 0.5 * kStep || held.is_near(near.at.point, 2 * spot.radius)) break;
    if (near.at.feature != ClosestPoint::Feature::face) {
      // On an open border, or on an edge that the body ends at, the normal is no face's: it turns too fast there.
      const Vec3 face = normal_of(surface, near.triangle);
      if (face.dot(next_normal) < std::cos(2 * kSharpest)) break;
    }
    const Vec3 inward = near.at.point;
    if (thickness_below(surface, inward, next_normal, 0.2) < 3 * spot.depth) break;
    at = next;
    normal = next_normal;
    heading = (heading - heading.dot(normal) * normal).normalized();
    out.push_back(at);
  }
  return out;
}

}  // namespace kt
