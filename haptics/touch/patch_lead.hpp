#pragma once
// The picture of a body whose part around the contact runs ahead of the rest.
#include <vector>

#include "core/body/mesh.hpp"

namespace kt {

/// Where the rest of a body is while its part around the contact runs ahead of it, for pictures: between two refreshes
/// that part moves with the ticks, and the rest stands where the last refresh had it. Its lead fades over the next rows
/// of nodes; without that, neighbours at the rim are drawn millimetres apart when the body swings.
class PatchLead {
 public:
  static constexpr int kRows = 8;  ///< of nodes around the patch over which its lead fades to nothing

  /// @param mesh  of the whole body; nodes of an edge, of tetrahedra or else triangles, are neighbours
  /// @param held  nodes that never move
  PatchLead(const Mesh& mesh, const std::vector<int>& held);
  /// @param before  where the body was without the patch laid over (3n) [m]      @param x  with it; becomes the picture
  void fade(const VectorX& before, VectorX& x) const;

 private:
  std::vector<int> first_, neighbour_;  // of node i: neighbour_[first_[i] .. first_[i + 1])
  std::vector<char> is_held_;
};

}  // namespace kt
