#pragma once
// Points in 113-bit arithmetic, in which a test's truth is computed; long double where the compiler has no more.
#include <cmath>

#include "core/base/types.hpp"

namespace kt::quad {

#ifdef __SIZEOF_FLOAT128__
__extension__ typedef __float128 Real;
constexpr bool kIsLong = true;
#else
using Real = long double;
constexpr bool kIsLong = false;
#endif

struct Point {
  Real x, y, z;
};
inline Point operator+(Point a, Point b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Point operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Point operator*(Real s, Point a) { return {s * a.x, s * a.y, s * a.z}; }
inline Point point(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
inline Real dot(Point a, Point b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Point cross(Point a, Point b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline Real component(Point a, int k) { return k == 0 ? a.x : k == 1 ? a.y : a.z; }
inline Real absolute(Real v) { return v < 0 ? -v : v; }
inline Real clamp(Real s) { return s < 0 ? 0 : s > 1 ? 1 : s; }
inline Real square_root(Real v) {
  if (!(v > 0)) return 0;
  Real s = std::sqrt(static_cast<long double>(v));
  for (int i = 0; i < 2; ++i) s = (s + v / s) / 2;
  return s;
}

}  // namespace kt::quad
