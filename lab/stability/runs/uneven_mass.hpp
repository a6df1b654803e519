#pragma once
#include "core/body/deformable_model.hpp"

namespace kt {

/// A body whose upper half is heavier or lighter than its material says: the same forces, another mass. Refers to
/// `model`, which must be without damping by mass and without gravity.
class UnevenMass final : public DeformableModel {
 public:
  /// @param ratio  of the densities, upper half over lower
  UnevenMass(const DeformableModel& model, double ratio) : model_(model), mass_(model.mass()) {
    const Bounds box = bounds(model.mesh());
    VectorX scale = VectorX::Ones(mass_.rows());
    for (int i = 0; i < model.mesh().num_nodes(); ++i)
      if (node(model.mesh().x, i).z() > box.centre().z()) node(scale, i).setConstant(std::sqrt(ratio));
    mass_ = scale.asDiagonal() * mass_ * scale.asDiagonal();
  }
  const Mesh& mesh() const override { return model_.mesh(); }
  const SparseMatrix& mass() const override { return mass_; }
  const std::vector<int>& fixed_nodes() const override { return model_.fixed_nodes(); }
  void force(const State& state, VectorX& out) const override { model_.force(state, out); }
  void update_tangent(const State& state, TangentKind kind, Tangent& out) const override {
    model_.update_tangent(state, kind, out);
  }
  ModelInfo info() const override { return model_.info(); }

 private:
  const DeformableModel& model_;
  SparseMatrix mass_;
};

}  // namespace kt
