#pragma once
// How the whole body answers forces on a patch: the motions that reducers by projection are made of.
#include <vector>

#include "core/linear/free_dofs.hpp"
#include "core/linear/sparse_solver.hpp"
#include "core/local/reducer.hpp"

namespace kt {

/// mass, damping, stiffness of the free nodes, symmetric (what turns with a damper is left out: it is no property of
/// the linear body), with the force at zero velocity.
struct FreeBody {
  FreeBody() = default;
  explicit FreeBody(const TangentModel& tangent);
  FreeDofs dofs;
  SparseMatrix mass, damping, stiffness;
  VectorX force, velocity;  ///< f0 without the damping of v0 [N]; v0 [m/s]
  VectorX x;                ///< of all nodes [m]
  /// Unit forces on the patch's free nodes that are in reach, then on those of its rim if asked for, (free x inputs).
  MatrixX inputs(const SurfacePatch& patch, bool with_rim = false) const;
};

/// s^2 M + s D + K. Bodies that keep all three in one pattern are summed number by number.
SparseMatrix dynamic_stiffness(const FreeBody& body, double s);

/// (s^2 M + s D + K)^-1 [loads, force at rest] for s = 2 pi f of each `shift` f [Hz], ascending, >= 0: how the body
/// moves under forces that grow as e^(s t); then, how it moves now. The loads are unit forces on the patch nodes in
/// reach at the first and the last shift, where what is felt is near the tool, and smooth_loads between, where the
/// whole body resounds; on the rim smooth ones, at the first shift only. A body that is free to move has no response at
/// 0: there the mass at 20 Hz is added. `slopes`: also how the response to smooth_loads changes with s (at 0: with
/// s^2), for one more solution and no factorization: that serves as well as twice as many shifts (Hermite
/// interpolation; Antoulas 2005, section 11.3). `echoes`: how often the response to the patch's resultant force is
/// answered again, (A^-1 M)^k A^-1 f at the first shift, which brings in the slowest vibrations that the patch can
/// excite: three columns each, the last. Throws IndefiniteTangent when a matrix is not positive definite. `solver`:
/// keeps its symbolic analysis for the next body.
MatrixX responses(const FreeBody& body, const SurfacePatch& patch, const std::vector<double>& shifts,
                  SparseSolver& solver, int echoes, bool slopes);
MatrixX responses(const FreeBody& body, const SurfacePatch& patch, const std::vector<double>& shifts);

/// Motions X, and the body confined to them: X^T M X, X^T D X, X^T K X.
struct ConfinedMotions {
  RowMatrix X;
  MatrixX mass, damping, stiffness;
};

/// The motions of responses(). No product with K is needed: where (K + d D + m M) x = load was solved, K x is known.
ConfinedMotions confined_responses(const FreeBody& body, const SurfacePatch& patch, const std::vector<double>& shifts,
                                   SparseSolver& solver, int echoes, bool slopes);

}  // namespace kt
