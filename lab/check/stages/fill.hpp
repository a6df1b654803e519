#pragma once
// A closed surface, filled with tetrahedra that can be stepped: decimated where it is over the budget, evenly where
// that leaves flat ones.
#include <optional>
#include <string>

#include "lab/check/mesh_work.hpp"

namespace kt {

constexpr int kMostBudgets = 4;  ///< where fewer triangles would cross one another

std::string percent_of_size(double distance);
bool is_over_budget(const Mesh& surface, const MeshWork& work);

/// Closed, manifold, turned the right way and free of intersections.
bool is_fillable(const MeshReport& report);

/// With as many triangles as the budget allows, or up to kMostBudgets times as many where fewer would cross one
/// another; with more only where collapsing leaves more: pieces stay.
/// @param is_clean the result must be fillable
/// @throws RunError when there is none
Mesh decimated(const Mesh& surface, const MeshWork& work, bool is_clean, StageResult& out);

/// By the first tetrahedralizer that can. Where its tetrahedra are flat: with a surface decimated evenly from the
/// `fine` one, if it was decimated; else by another whose are less so and no needles, and that leaves no more
/// triangles. Failures of the others lower the verdict. Nothing when none can.
std::optional<Mesh> filled(const Mesh& surface, const Mesh& fine, const MeshWork& work, StageResult& out);

}  // namespace kt
