#pragma once
#include "core/body/wrapping_model.hpp"

namespace kt {

/// A body whose upper half is heavier or lighter than its material says: the same forces, another mass. Refers to
/// `model`, which must be without damping by mass and without gravity.
class UnevenMass final : public WrappingModel {
 public:
  /// @param ratio  of the densities, upper half over lower
  UnevenMass(const DeformableModel& model, double ratio) : WrappingModel(model), mass_(model.mass()) {
    const Bounds box = bounds(model.mesh());
    VectorX scale = VectorX::Ones(mass_.rows());
    for (int i = 0; i < model.mesh().num_nodes(); ++i)
      if (node(model.mesh().x, i).z() > box.centre().z()) node(scale, i).setConstant(std::sqrt(ratio));
    mass_ = scale.asDiagonal() * mass_ * scale.asDiagonal();
  }
  const SparseMatrix& mass() const override { return mass_; }

 private:
  SparseMatrix mass_;
};

}  // namespace kt
