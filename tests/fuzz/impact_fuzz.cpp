// First impacts of tools with a triangle (collision/impact/tool_impact.hpp, collision/impact/hull_impact.hpp) of
// whatever numbers a fuzzer makes up, NaN, infinite and tiny ones too: what must hold without knowing the answer, and,
// of whole numbers, that tool and triangle stay apart until then.
//
//     scripts/fuzz impact_fuzz
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>

#include "collision/impact/hull_impact.hpp"
#include "collision/impact/tool_impact.hpp"
#include "collision/shape/closest_point.hpp"
#include "tests/fuzz/numbers.hpp"

namespace {

using kt::Contact;
using kt::Vec3;
using kt::fuzz::Numbers;

constexpr int kPoint = 0, kSphere = 1;  // tools of tool_impact.hpp; 2 .. 4: hulls of one to three corners

struct Case {
  int tool = kPoint;
  double radius = 0;
  Vec3 x[12];  ///< the hull at the start and at the end, the triangle at the start and at the end

  int corners() const { return tool <= kSphere ? 1 : tool - 1; }
};

void require(bool holds, const char* what, const Case& c) {
  if (!holds)
    std::fprintf(stderr, "tool %d, radius %a; hull at start, at end, triangle at start, at end:\n", c.tool, c.radius);
  kt::fuzz::require(holds, what, c.x);
}

std::optional<Contact> impact_of(const Case& c) {
  const Vec3 t0[3] = {c.x[6], c.x[7], c.x[8]}, t1[3] = {c.x[9], c.x[10], c.x[11]};
  if (c.tool <= kSphere) {
    using Kind = kt::ToolShape::Kind;
    return kt::find_triangle_impact({c.tool == kPoint ? Kind::point : Kind::sphere, c.radius}, {c.x[0], c.x[3]}, t0,
                                    t1);
  }
  kt::MovingHull hull;
  for (int i = 0; i < 3; ++i) hull.x_t0[i] = c.x[i], hull.x_t1[i] = c.x[3 + i];
  hull.corners = c.corners();
  hull.radius = c.radius;
  return kt::find_hull_impact(hull, t0, t1);
}

void check(const std::optional<Contact>& hit, const Case& c) {
  if (!hit) return;
  require(hit->toi >= 0 && hit->toi <= 1, "0 <= toi <= 1", c);
  require(hit->bary.allFinite() && std::abs(hit->bary.sum() - 1) < 1e-12, "weights sum up to 1", c);
  require(hit->bary.minCoeff() > -1e-12, "no weight is negative", c);
  require(std::abs(hit->normal.norm() - 1) < 1e-9, "the normal is a unit vector", c);
  require(std::isfinite(hit->gap), "the gap is finite", c);
  bool is_finite = std::isfinite(c.radius);
  for (int i = 0; i < 12; ++i) is_finite = is_finite && (i % 3 >= c.corners() && i < 6 ? true : c.x[i].allFinite());
  require(is_finite, "what is not finite hits nothing", c);
}

/// A segment goes through a face, or touches it.
bool pierces(const Vec3& from, const Vec3& to, const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto volume = [](const Vec3& p, const Vec3& q, const Vec3& r, const Vec3& s) {
    return (q - p).cross(r - p).dot(s - p);
  };
  const double u = volume(from, to, a, b), v = volume(from, to, b, c), w = volume(from, to, c, a);
  const bool is_through = (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
  return is_through && volume(a, b, c, from) * volume(a, b, c, to) <= 0;
}

bool intersect_at_start(const Case& c) {
  const Vec3 *hull = c.x, *face = c.x + 6;
  const int n = c.corners(), edges = n == 3 ? 3 : n - 1;
  for (int i = 0; i < edges; ++i)
    if (pierces(hull[i], hull[(i + 1) % 3], face[0], face[1], face[2])) return true;
  for (int k = 0; k < 3 && n == 3; ++k)
    if (pierces(face[k], face[(k + 1) % 3], hull[0], hull[1], hull[2])) return true;
  return false;
}

/// At most this far apart at time t; too much where they intersect.
double distance_at(const Case& c, double t) {
  Vec3 hull[3], face[3];
  for (int i = 0; i < 3; ++i) {
    hull[i] = (1 - t) * c.x[i] + t * c.x[3 + i];
    face[i] = (1 - t) * c.x[6 + i] + t * c.x[9 + i];
  }
  double least = INFINITY;
  const int n = c.corners(), edges = n == 3 ? 3 : n - 1;
  for (int i = 0; i < n; ++i)
    least = std::min(least, std::sqrt(kt::closest_point_on_triangle(hull[i], face[0], face[1], face[2]).distance_sq));
  for (int k = 0; k < 3 && n == 3; ++k)
    least = std::min(least, std::sqrt(kt::closest_point_on_triangle(face[k], hull[0], hull[1], hull[2]).distance_sq));
  for (int i = 0; i < edges; ++i)
    for (int k = 0; k < 3; ++k) {
      const Vec3 &a0 = hull[i], &a1 = hull[(i + 1) % 3], &b0 = face[k], &b1 = face[(k + 1) % 3];
      const auto [s, r] = kt::closest_parameters(a0, a1, b0, b1);
      least = std::min(least, (a0 + s * (a1 - a0) - b0 - r * (b1 - b0)).norm());
    }
  return least;
}

/// Impacts are one-sided; with the triangle and with its back, nothing may touch before the first of the two.
void check_apart_until(const std::optional<Contact>& hit, const Case& c, double unit) {
  const double rounding = 1e-11 * unit;
  // Touching at the start is a hit only when it closes.
  if (distance_at(c, 0) - c.radius <= rounding || intersect_at_start(c)) return;
  Case turned = c;
  std::swap(turned.x[7], turned.x[8]);
  std::swap(turned.x[10], turned.x[11]);
  const std::optional<Contact> back = impact_of(turned);
  check(back, turned);
  const double until = std::min(hit ? hit->toi : 1, back ? back->toi : 1);
  for (int k = 1; k <= 8; ++k)
    require(distance_at(c, until * k / 8.0) - c.radius > -rounding, "they are apart until they touch", c);
}

}  // namespace

/// First byte: the tool. Second: the kind of the numbers.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 3) return 0;
  Case c;
  c.tool = data[0] % 5;
  Numbers numbers({data + 1, size - 1});
  const double radius = std::abs(numbers.next());
  c.radius = c.tool == kPoint ? 0 : c.tool == kSphere && radius == 0 ? 1 : radius;
  for (int i = 0; i < 12; ++i)
    if (i >= 6 || i % 3 < c.corners()) c.x[i] = numbers.point();
  const std::optional<Contact> hit = impact_of(c);
  check(hit, c);
  if (numbers.is_whole()) check_apart_until(hit, c, std::ldexp(1, numbers.scale()));
  return 0;
}
