#pragma once
// Linearization of any model at a global state.                                               Paper eqs. (3)-(4).
#include "core/body/deformable_model.hpp"

namespace kt {

/// M a = f0 + dfdx (x - x0) + dfdv (v - v0).
struct TangentModel {
  State state;              ///< x0, v0
  VectorX f0;               ///< [N], (3n)
  SparseMatrix dfdx, dfdv;  ///< [N/m], [N s/m], (3n x 3n)
  SparseMatrix mass;        ///< [kg], (3n x 3n)
  std::vector<int> fixed_nodes;
};

/// `out`: of the same model, its storage is used again: a matrix of some tens of megabytes costs as much to allocate as
/// to compute.
void linearize(const DeformableModel& model, const State& state, TangentKind kind, TangentModel& out);
TangentModel linearize(const DeformableModel& model, const State& state, TangentKind kind = TangentKind::exact);

}  // namespace kt
