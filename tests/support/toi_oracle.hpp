#pragma once
// First contact of a moving vertex and face, or of two edges, by other means than the engine's: all roots of the
// coplanarity in 113-bit arithmetic, and the distance there. For coordinates that are small integers, where distances
// that are not zero are far from it. Slow, and only for tests.
#include <optional>

#include "core/base/types.hpp"

namespace kt {

struct IntegerMotion {
  int t0[4][3], t1[4][3];
};

/// Nearest double of the first time, or nothing.
std::optional<double> first_contact_of_vertex_face(const IntegerMotion& x);
std::optional<double> first_contact_of_edges(const IntegerMotion& x);

/// Distance of the features at time t, right to the last bits of a double.
double feature_distance(bool is_face, const Vec3 (&x_t0)[4], const Vec3 (&x_t1)[4], double t);

}  // namespace kt
