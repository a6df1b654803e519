#pragma once
// A body that is only its matrices: f = -K (x - x_rest) - D v. Closed forms exist for everything it does.
#include "core/body/deformable_model.hpp"

namespace kt {

class LinearModel final : public DeformableModel {
 public:
  /// @param mass, damping, stiffness  (3n x 3n), symmetric; the body rests at x = 0.
  LinearModel(const MatrixX& mass, const MatrixX& damping, const MatrixX& stiffness, std::vector<int> fixed = {})
      : mass_(mass.sparseView()),
        damping_(damping.sparseView()),
        stiffness_(stiffness.sparseView()),
        fixed_(std::move(fixed)) {
    mesh_.x = VectorX::Zero(mass.rows());
  }
  const Mesh& mesh() const override { return mesh_; }
  const SparseMatrix& mass() const override { return mass_; }
  const std::vector<int>& fixed_nodes() const override { return fixed_; }
  void force(const State& state, VectorX& out) const override { out = -stiffness_ * state.x - damping_ * state.v; }
  void update_tangent(const State&, TangentKind, Tangent& out) const override { out = {-stiffness_, -damping_}; }
  ModelInfo info() const override { return {"linear", "", {}}; }

 private:
  Mesh mesh_;
  SparseMatrix mass_, damping_, stiffness_;
  std::vector<int> fixed_;
};

/// One free node whose three directions are alike: x'' = -omega^2 x - 2 zeta omega x'.
inline LinearModel oscillator(double omega, double zeta) {
  const MatrixX one = MatrixX::Identity(3, 3);
  return {one, 2 * zeta * omega * one, omega * omega * one};
}

}  // namespace kt
