#pragma once
// Stiffness of a zone's leaves at the state of the coarse body.
#include "core/fine/fine_zone.hpp"

namespace kt {

/// What a leaf's material is like: a cell of linear elements is strained alike everywhere, one of quadratic elements
/// as its own field says at the leaf's points; inclusions count by the leaf's own middle at rest.
struct FineState {
  const State& coarse;  ///< positions and velocities of the body
  TangentKind kind = TangentKind::symmetric;
};

/// (3 unknown x 3 unknown) [N/m], symmetric, in whole node blocks.
SparseMatrix fine_stiffness(const FineBody& body, const FineZone& zone, const FineState& state);

}  // namespace kt
