#pragma once
// Do a point and a triangle, or two segments, touch? In whole numbers, so without any rounding, and by other means than
// the engine: no coordinate planes, no polynomials. Coordinates up to 2^9.
#include <array>
#include <cstdint>

namespace kt::fuzz {

using Whole = std::array<std::int64_t, 3>;

inline Whole operator-(const Whole& a, const Whole& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline std::int64_t dot(const Whole& a, const Whole& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Whole cross(const Whole& a, const Whole& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline bool is_zero(const Whole& a) { return a == Whole{0, 0, 0}; }

inline bool is_on_segment(const Whole& p, const Whole& a, const Whole& b) {
  return is_zero(cross(p - a, b - a)) && dot(p - a, p - b) <= 0;
}

inline bool point_touches_triangle(const Whole& p, const Whole& a, const Whole& b, const Whole& c) {
  const Whole n = cross(b - a, c - a);
  if (is_zero(n)) return is_on_segment(p, a, b) || is_on_segment(p, b, c) || is_on_segment(p, c, a);
  const auto is_left = [&](const Whole& from, const Whole& to) { return dot(cross(to - from, p - from), n) >= 0; };
  return dot(n, p - a) == 0 && is_left(a, b) && is_left(b, c) && is_left(c, a);
}

inline bool segments_touch(const Whole& a0, const Whole& a1, const Whole& b0, const Whole& b1) {
  const Whole u = a1 - a0, v = b1 - b0, d = b0 - a0, n = cross(u, v);
  if (is_zero(n))
    return is_on_segment(a0, b0, b1) || is_on_segment(a1, b0, b1) || is_on_segment(b0, a0, a1) ||
           is_on_segment(b1, a0, a1);
  const std::int64_t s = dot(cross(d, v), n), r = dot(cross(d, u), n), all = dot(n, n);
  return dot(n, d) == 0 && s >= 0 && s <= all && r >= 0 && r <= all;
}

}  // namespace kt::fuzz
