#pragma once
// The tangent of a body of which only forces are known, by central differences.
#include "core/body/deformable_model.hpp"

namespace kt {

/// Derivatives of model.force() at `state`, for models that bring none of their own (DeformableModel's default).
///
/// Two nodes may act on one another when they share a tetrahedron, or a triangle where the mesh has no tetrahedra; a
/// force that reaches farther is not seen, which check_model() reports. Right to about 1e-8 of the largest entry.
///
/// Cost: 12 calls of force() a colour, where nodes of one colour have no neighbour in common: 27 to 50 colours, so 300
/// to 600 calls, for a body of tetrahedra, whatever its size. A tangent of one's own costs a few.
///
/// definite: the symmetric part, and as much of the identity as makes -dfdx and -dfdv positive definite (to 1e-8 of
/// their largest diagonal entry), within a factor of four (Nocedal and Wright, Numerical Optimization, algorithm 3.3).
/// Source of the colouring: Curtis, Powell and Reid, On the estimation of sparse Jacobian matrices, 1974.
void difference_tangent(const DeformableModel& model, const State& state, TangentKind kind, Tangent& out);

/// Of every node: the distance at rest to the nearest node of its elements that does not lie at the same place [m]; the
/// body's size where there is none.
VectorX shortest_edges(const Mesh& mesh);

}  // namespace kt
