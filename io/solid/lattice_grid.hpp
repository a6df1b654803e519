#pragma once
// A box of cubes, each in six tetrahedra along its diagonal as kuhn_block() cuts it.
#include <array>
#include <optional>
#include <vector>

#include "core/body/mesh.hpp"

namespace kt {

struct LatticeGrid {
  Vec3 origin = Vec3::Zero();
  Vec3 edge = Vec3::Zero();  ///< of a cube along each axis [m], a little different from axis to axis
  std::array<int, 3> count{1, 1, 1};

  int num_cubes() const { return count[0] * count[1] * count[2]; }
  int cube(const std::array<int, 3>& at) const { return at[0] + count[0] * (at[1] + count[1] * at[2]); }
  std::array<int, 3> place_of(int cube) const {
    return {cube % count[0], cube / count[0] % count[1], cube / count[0] / count[1]};
  }
  /// The cube that holds a place, or is nearest to it.
  std::array<int, 3> holding(const Vec3& place) const;
  Vec3 corner(const std::array<int, 3>& at) const { return origin + edge.cwiseProduct(Vec3(at[0], at[1], at[2])); }
  Vec3 middle(int cube) const { return corner(place_of(cube)) + 0.5 * edge; }
  /// Corners of the lattice are numbered along x, then y, then z.
  int node(const std::array<int, 3>& at) const { return at[0] + (count[0] + 1) * (at[1] + (count[1] + 1) * at[2]); }
  int num_nodes() const { return (count[0] + 1) * (count[1] + 1) * (count[2] + 1); }
};

/// Around a box, with cubes of at most that edge; of a box that is flatter than half of it, half of it. The box is
/// filled exactly, but where a part of it is clamped: there nodes lie in the plane where that part ends, cubes fill the
/// longer side of the plane, and reach out of the box on the other. So across an axis along which the box is an edge
/// long or more, and the end is no nearer to the box's than a tenth of an edge; of two ends at the lower. A clamped
/// part that is narrower than an edge, and than the box, along another axis has no such plane.
LatticeGrid make_lattice_grid(const Bounds& box, double edge, const std::optional<Bounds>& clamped = {});

/// The six tetrahedra of a cube: the order of axes in which each goes from the lowest corner to the highest.
inline constexpr std::array<std::array<int, 3>, 6> kKuhnAxes{
    {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};

/// Corners of a tetrahedron as steps from the cube's lowest corner, of positive volume.
std::array<std::array<int, 3>, 4> kuhn_corners(int tetrahedron);
/// Weights of these corners for a place in coordinates of the cube, 0 to 1 along each edge.
std::array<double, 4> kuhn_weights(int tetrahedron, const Vec3& place);
/// The tetrahedron that holds it.
int kuhn_holding(const Vec3& place);

/// Which cubes the triangles pass through; at their planes' boxes, so some that they only come near.
std::vector<char> touched_cubes(const LatticeGrid& grid, const Mesh& surface);

}  // namespace kt
