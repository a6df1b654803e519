#pragma once
// What is wrong with a mesh, and where. Looks only; io/surface/mesh_repair.hpp changes.
#include <optional>
#include <string>
#include <vector>

#include "core/body/mesh.hpp"

namespace kt {

/// Where a defect is: a point to look at and the nodes and triangles (or tetrahedra) involved, counted from 0.
struct MeshPlace {
  Vec3 at = Vec3::Zero();  ///< [mesh unit]; of nodes with NaN: as stored
  std::vector<int> nodes, triangles, tetrahedra;
};

struct MeshReport {
  int nodes = 0, triangles = 0, tetrahedra = 0, edges = 0;
  int components = 0;        ///< pieces that hang together over edges
  int euler = 0;             ///< V - E + F, of used nodes
  std::optional<int> genus;  ///< number of handles; only of a closed manifold surface
  Bounds box;                ///< of the finite nodes [mesh unit]
  double area = 0;           ///< [unit^2]
  double volume = 0;         ///< enclosed [unit^3]; meaningless when open
  double tetrahedra_volume = 0;
  double edge_min = 0, edge_mean = 0, edge_max = 0;  ///< [unit]
  std::string likely_unit;                           ///< a guess from the size, in words

  std::vector<MeshPlace> non_finite;         ///< nodes with NaN or infinite coordinates
  std::vector<MeshPlace> isolated_nodes;     ///< no triangle and no tetrahedron uses them
  std::vector<MeshPlace> coincident_nodes;   ///< groups of nodes with equal coordinates
  std::vector<MeshPlace> degenerate;         ///< triangles without area
  std::vector<MeshPlace> duplicates;         ///< triangles over the same three nodes as an earlier one
  std::vector<MeshPlace> open_edges;         ///< one triangle only
  std::vector<MeshPlace> nonmanifold_edges;  ///< three or more triangles
  std::vector<MeshPlace> nonmanifold_nodes;  ///< several fans of triangles touch in one node
  std::vector<MeshPlace> flipped;            ///< triangles against the orientation of most of their piece
  std::vector<MeshPlace> one_sided;   ///< pieces that cannot be oriented (a Moebius strip), by their first triangle
  std::vector<MeshPlace> inside_out;  ///< closed pieces whose normals point the wrong way, by their first triangle
  std::vector<MeshPlace>
      nested;  ///< closed pieces inside another piece but pointing outward: two solids in one place, or a cavity
  std::vector<MeshPlace> self_intersections;  ///< pairs of triangles that meet where they should not
  std::vector<MeshPlace> flat_tetrahedra;     ///< without volume
  bool self_intersections_checked = false;    ///< needs CGAL
  bool self_intersections_complete = true;    ///< false: stopped at MeshExamination::max_intersections

  bool closed() const { return triangles > 0 && open_edges.empty(); }
  bool manifold() const { return nonmanifold_edges.empty() && nonmanifold_nodes.empty(); }
  /// Nothing to complain about: closed, manifold, oriented outward, free of every defect that was looked for.
  bool clean() const;
};

struct MeshExamination {
  bool self_intersections = true;  ///< the only slow part; without CGAL it is skipped
  std::size_t max_intersections = 100000;
};

/// The unit, as a scale to metres, that brings the longest edge of the box nearest to 15 cm, the size of organs and
/// hand tools; 0 for a box without a size.
double likely_scale(const Bounds& box);
/// The same in words: "mm (the longest side would be 0.12 m)".
std::string likely_unit(const Bounds& box);

/// Never throws for a bad mesh: that is what it is for. Indices must be in range (all readers check that).
MeshReport examine(const Mesh& mesh, const MeshExamination& how = {});

/// Names and lists of all defects of a report, in the order of MeshReport, for printing.
struct DefectList {
  std::string key, title;                ///< "open_edges", "open edges"
  const std::vector<MeshPlace>* places;  ///< borrowed from the report
  std::string cure{};                    ///< a command, where one helps that nobody would look for
};
std::vector<DefectList> defects(const MeshReport& report);

/// "at (0.1, 0.2, 0.3), nodes 4 5, triangles 7"
std::string describe(const MeshPlace& place);

/// Pairs of triangles that cross, touch or overlap without sharing those nodes, exactly decided. Triangles that are
/// degenerate, duplicates or not finite are left out. `complete` is set to false when max_pairs is reached.
/// Defined in self_intersections_cgal.cpp: call only when KT_WITH_CGAL.
std::vector<std::array<int, 2>> find_self_intersections(const Mesh& mesh, std::size_t max_pairs, bool& complete);

}  // namespace kt
