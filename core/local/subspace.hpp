#pragma once
// Local models whose coordinates are motions of the whole body, not nodes: what reducers by projection share.
#include <optional>

#include "core/local/reducer.hpp"
#include "core/local/responses.hpp"

namespace kt {

/// True where one orthonormalization is good enough for the tolerance, as confine() of ConfinedMotions makes do with.
bool is_one_pass(double tolerance, int firm);

/// Columns spanning what `motions` span, orthonormal in the mass, (free x r): directions that are the others' to within
/// `tolerance` of their length (in the mass) are dropped; the last `firm` ones only within a hundredth of it.
RowMatrix orthonormal_motions(const SparseMatrix& mass, const MatrixX& motions, double tolerance, int firm = 0);

/// The body confined to the motions V, orthonormal in the mass: in the coordinates of its own vibrations, so that mass
/// is the identity, stiffness diagonal, and damping too where it is proportional to within `kProportional`. Motions
/// that the body gives way to lose their spring (`definite_tangent`). `combination`: the vibrations in terms of V.
LocalModel confine(const TangentModel& tangent, const FreeBody& body, SurfacePatch patch, const RowMatrix& V,
                   MatrixX* combination = nullptr);

/// The same for motions that are not orthonormal: what repeats others is dropped as by orthonormal_motions(), and no
/// orthonormal motions are formed. `combination`: the vibrations in terms of X. Nothing, and the patch stays, where no
/// motion is left.
std::optional<LocalModel> confine(const TangentModel& tangent, const FreeBody& body, SurfacePatch& patch,
                                  const ConfinedMotions& motions, double tolerance, int firm, MatrixX& combination);

}  // namespace kt
