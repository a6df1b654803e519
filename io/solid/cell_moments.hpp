#pragma once
// How much material a cell of a lattice has, where its middle is, and how far it spreads: what ten-node cells that the
// surface cuts are integrated by.
#include "core/body/embedded_surface.hpp"
#include "io/solid/lattice_grid.hpp"

namespace kt {

/// Of the material of one of a cube's six tetrahedra, in coordinates of the cube.
struct CellMoments {
  double share = 0;  ///< of the tetrahedron's volume
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();

  /// @param spread  mean of the squares of the distances from its middle
  void add(double its_share, const Vec3& middle, const Mat3& spread);
};

/// Of a tetrahedron: mean of the squares of the distances from its middle.
Mat3 spread_of(const std::array<Vec3, 4>& corners);

/// Of a tetrahedron that is material all through.
const CellMoments& whole_cell(int tetrahedron);

/// The places that have the moments; of a whole cell Gauss's. What is no material counts next to nothing, so that cells
/// with a sliver of it do not move freely.
CellPoints cell_points(int tetrahedron, const CellMoments& moments);

}  // namespace kt
