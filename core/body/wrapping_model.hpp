#pragma once
// The base of models that change a part of another model: all else is the other's.
#include "core/body/deformable_model.hpp"

namespace kt {

/// Borrows the model.
class WrappingModel : public DeformableModel {
 public:
  explicit WrappingModel(const DeformableModel& model) : model_(model) {}
  const Mesh& mesh() const override { return model_.mesh(); }
  const SparseMatrix& mass() const override { return model_.mass(); }
  const std::vector<int>& fixed_nodes() const override { return model_.fixed_nodes(); }
  void force(const State& state, VectorX& out) const override { model_.force(state, out); }
  void update_tangent(const State& state, TangentKind kind, Tangent& out) const override {
    model_.update_tangent(state, kind, out);
  }
  ModelInfo info() const override { return model_.info(); }
  double free_share(const VectorX& x, const VectorX& dx) const override { return model_.free_share(x, dx); }

 protected:
  const DeformableModel& model_;
};

}  // namespace kt
