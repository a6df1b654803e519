#pragma once
// Motions of a whole body that reach far from a contact: how it yields to smooth loads on the patch, and its slowest
// vibrations. Both are improved a little at each refresh, from where the last one stopped, instead of solved for.
#include <functional>

#include "core/local/local_model.hpp"
#include "core/local/node_blocks.hpp"

namespace kt {

inline constexpr int kFarEach = 12;  ///< motions of either kind
using FarRows = NodeRows<kFarEach>;  // (3 free x 12)

/// What is known of the body: K u, M u, and roughly K^-1 f.
struct FarOperators {
  std::function<void(const FarRows&u, FarRows&out)> stiffness, mass;
  std::function<FarRows(const FarRows& forces)> precondition;
};

/// Unit forces on all nodes of the patch, and the same times their distance from its middle along each axis [m].
FarRows smooth_loads(const FreeDofs& dofs, const VectorX& x, const SurfacePatch& patch);

/// Displacements that stretch, turn and carry the body evenly: what vibrations are sought from.
FarRows even_motions(const FreeDofs& dofs, const VectorX& x);

/// Towards K motions = loads, by so many steps of conjugate gradients. False when the motions are lost: not finite.
bool improve_yielding(FarRows& motions, const FarRows& loads, const FarOperators& body, int steps);

/// Towards the slowest vibrations: the best that the motions can make of one another (Rayleigh and Ritz), then the same
/// steps under their own inertia (inverse iteration). Motions that are the others' become zero. False as above.
bool improve_vibrations(FarRows& motions, const FarOperators& body, int steps);

}  // namespace kt
