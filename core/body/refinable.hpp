#pragma once
// What a model tells of its material, for cells finer than its own (core/fine/). Optional: without it a body is taken
// as an isotropic solid.
#include <span>

#include "core/body/deformable_model.hpp"

namespace kt {

/// dP/dF [Pa], (9 x 9), symmetric; F column by column.
using Moduli = Eigen::Matrix<double, 9, 9>;

/// Const, like the model that it belongs to.
class Refinable {
 public:
  virtual ~Refinable() = default;
  /// Corners of a tetrahedron of the mesh, and where it is quadratic the middles of its edges 01 12 20 03 13 23.
  virtual std::span<const int> cell_nodes(int cell) const = 0;
  /// Of the material outside of inclusions. `kind` as of the body's tangent.
  /// @param F     deformation gradient
  /// @param rate  of F [1/s]
  virtual Moduli moduli(TangentKind kind, const Mat3& F, const Mat3& rate) const = 0;
  /// What inclusions multiply the stiffness by where the body at rest is at `place` [m].
  virtual double stiffness_factor(const Vec3& place) const = 0;
  /// Damping over stiffness of the material [s].
  virtual double retardation() const = 0;
};

/// Of stiffer or softer balls, the factor of the last one that holds a place; 1 outside of all.
template <class Balls>
double stiffness_in(const Balls& balls, const Vec3& place) {
  double out = 1;
  for (const auto& ball : balls)
    if ((place - ball.center).norm() <= ball.radius) out = ball.stiffer;
  return out;
}

/// What the model tells of itself; null: nothing.
inline const Refinable* told_by(const DeformableModel& model) { return dynamic_cast<const Refinable*>(&model.base()); }

}  // namespace kt
