#pragma once
// A body away from rest, and its force.
#include "core/body/deformable_model.hpp"
#include "tests/support/numbers.hpp"

namespace kt {

/// Every coordinate of every node moved by up to `distance` [m], and all moving.
inline State shaken(const DeformableModel& model, double distance, unsigned seed) {
  State s = rest_state(model);
  s.x += distance * random_vector(s.x.size(), seed);
  s.v = 0.1 * random_vector(s.x.size(), seed + 1);
  return s;
}

inline VectorX force(const DeformableModel& model, const State& state) {
  VectorX out;
  model.force(state, out);
  return out;
}

}  // namespace kt
