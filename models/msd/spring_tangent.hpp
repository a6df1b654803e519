#pragma once
// The derivatives of all springs' forces, written column by column: each block off the diagonal is one spring's, and
// the one on it is minus the sum of its column's others.
#include <vector>

#include "core/body/deformable_model.hpp"
#include "models/msd/springs.hpp"

namespace kt {

class SpringTangent {
 public:
  SpringTangent() = default;
  /// @param springs  at most one between two nodes
  SpringTangent(int num_nodes, const std::vector<Spring>& springs);

  /// The pattern with all values zero, (3n x 3n), in whole 3 x 3 node blocks.
  const SparseMatrix& pattern() const { return pattern_; }

  /// Sets both matrices, which get the pattern if they have another (judged by their sizes), to
  ///   dfdx = k u u^T + (tension + c rate / length)(I - u u^T) + (c / length) u w^T   off the diagonal,
  ///   dfdv = c u u^T,
  /// with u the direction of a spring and w the velocity across it. Definite: tension at least zero, and without what
  /// has c in dfdx, since the damper turns with the spring, which is not symmetric.
  void update(const std::vector<Spring>& springs, const State& state, TangentKind kind, Tangent& out) const;

 private:
  SparseMatrix pattern_;
  std::vector<int> begin_;      // of each node's blocks, in the order of the pattern
  std::vector<int> spring_of_;  // of each block; the number of springs: it is on the diagonal
  std::vector<int> diagonal_;   // which of its blocks
};

/// Of a spring's second end relative to its first.
struct Stretch {
  double length = 0, rate = 0;  ///< [m], [m/s]
  Vec3 direction, velocity;
};

inline Stretch stretch(const Spring& s, const State& state) {
  Stretch out;
  const Vec3 d = node(state.x, s.b) - node(state.x, s.a);
  // A collapsed spring has no direction of its own: any fixed one keeps the force finite and the step reproducible.
  out.length = std::max(d.norm(), 1e-9 * s.rest_length);
  out.direction = d.squaredNorm() > 0 ? Vec3(d / d.norm()) : Vec3(Vec3::UnitX());
  out.velocity = node(state.v, s.b) - node(state.v, s.a);
  out.rate = out.velocity.dot(out.direction);
  return out;
}

}  // namespace kt
