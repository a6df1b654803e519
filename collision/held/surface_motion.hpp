#pragma once
// When does a moving surface first meet itself?
#include "collision/broad/surface_pairs.hpp"

namespace kt {

/// Share of the straight motion from x_t0 to x_t1 (3n) at which the first of the pairs meets, never later than it does;
/// infinity when none does. 0: one meets at the start.
double first_meeting(std::span<const SurfacePair> pairs, const VectorX& x_t0, const VectorX& x_t1);

}  // namespace kt
