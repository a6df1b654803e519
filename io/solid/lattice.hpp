#pragma once
// A body made from any surface: a regular lattice of cubes, each in six tetrahedra, that hold material or a vertex of
// the surface. A tetrahedron that the surface cuts has its share of material. Inside is where the surface winds around
// a place more than half a time, so that open, overlapping and self-intersecting surfaces need no repair.
#include <functional>
#include <string>
#include <vector>

#include "core/body/mesh.hpp"

namespace kt {

struct LatticeOptions {
  double edge = 0;  ///< of the cubes, at most [m]; 0: as `nodes` asks for
  int nodes = 600;  ///< of the lattice, about; without an edge
  /// Longest edge of the surface over that of the cubes: its triangles move with cells at their corners alone.
  double longest = 0.25;
  bool is_quadratic = false;  ///< cells of ten nodes; `nodes` counts them
  /// Where a body in that box is clamped: the lattice has nodes where that ends. Empty: nowhere.
  std::function<Bounds(const Bounds& body)> clamped{};
  std::string name = "the surface";  ///< in messages
};

constexpr int kMostLatticeNodes = 20000;

/// What was made of a surface.
struct LatticeReport {
  int nodes = 0, tetrahedra = 0;
  bool is_quadratic = false;  ///< tetrahedra of ten nodes
  double edge = 0;            ///< mean of the cubes' [m]
  double volume = 0;          ///< of the material [m^3]
  int open_edges = 0;         ///< of one triangle each
  bool closes = false;   ///< every edge is passed as often one way as the other: it winds around places whole times
  int turned = 0;        ///< triangles that faced inward
  int degenerate = 0;    ///< triangles without area, left out
  double unsure = 0;     ///< share of the volume near the surface that this winds around 1/4 to 3/4 times
  int cut_cubes = 0;     ///< that the surface passes through
  int parted_cubes = 0;  ///< of these, with pieces of material that are apart in them
  std::vector<std::string> lines() const;
};

/// The lattice with the surface embedded in it: Mesh::embedded. Equal coordinates become one vertex, triangles without
/// area are left out, pieces that are inside out turned. Throws InputError for a surface that holds no material and for
/// an edge that asks for too many nodes.
Mesh make_lattice(const Mesh& surface, const LatticeOptions& options, LatticeReport* report = nullptr);

}  // namespace kt
