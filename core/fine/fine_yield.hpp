#pragma once
// How much softer the material of a zone is than its coarse cells: a compliance in series with the coarse body's,
// R = S_f - W S_c W^T, both with everything outside the zone held. W: the weights of fine nodes in their coarse cell.
// Coarse motions are fine ones too, so R is positive semidefinite, and zero where nothing is refined.
#include "core/fine/fine_stiffness.hpp"
#include "core/linear/sparse_solver.hpp"

namespace kt {

/// W: how the body's nodes move some of the zone's, (nodes x n); rows sum to 1.
SparseMatrix coarse_weights(const FineBody& body, const FineZone& zone, std::span<const int> nodes);

struct FineYield {
  MatrixX R;  ///< of the zone's num_points() [m/N], (3n x 3n), symmetric, semidefinite
  /// Its least eigenvalue over the largest before negative ones were set to zero, as springs have them, which are in
  /// places softer than the material that they stand for; 0: none was.
  double least = 0;
  double added = 0;        ///< to its diagonal, where such are slight: cells that a surface cuts [m/N]
  double retardation = 0;  ///< of the material: R yields with its damping [s]
};

/// @param dfdx    tangent of the body at the state [N/m], (3n x 3n), of the same kind; symmetric part read
/// @param solver  make_block_solver(); keeps its analysis while the zone stays
/// Throws IndefiniteTangent where either gives way: then the definite tangents of both are to be taken.
FineYield find_yield(const FineBody& body, const FineZone& zone, const FineState& state, const SparseMatrix& dfdx,
                     SparseSolver& solver);

}  // namespace kt
