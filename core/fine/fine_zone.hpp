#pragma once
// The cells of a body around a tool, refined: where the coarse cells are too stiff for a contact, how much softer the
// material is than they are can be found here alone, with everything outside held.
// Red refinement with its octahedron cut alike in every level (Bey 1995: at most three shapes of a cell), graded two to
// one; leaves are quadratic, and where a leaf meets smaller ones the nodes between its own hang on these.
#include "core/fine/fine_body.hpp"
#include "core/fine/fine_nodes.hpp"
#include "core/fine/leaf_stiffness.hpp"

namespace kt {

/// How small leaves are wanted: `edge` within `flat` of the centre, from there on larger by `slope` times the distance
/// [m]. A leaf's size is that of the cube which six such cells fill. `least_flat` is enough where there are not nodes
/// for more.
struct FineSize {
  double edge = 0, flat = 0, least_flat = 0, slope = 1;
  double at(double distance) const { return edge + slope * std::max(0.0, distance - flat); }
  bool operator==(const FineSize&) const = default;
};

struct FineZoneOptions {
  Vec3 centre = Vec3::Zero();  ///< where the tool touches, of the body at rest
  std::vector<Vec3> others{};  ///< where it or another one does, too
  double radius = 0;           ///< cells with a corner this near are refined, and those within size.flat [m]
  double reach = 0;            ///< of the surface that may be touched [m]
  /// Of an embedded surface: places that tools are held at are no nearer than that, and edges of its pieces no longer
  /// than twice that [m]; both wider by up to 1.7 on large leaves, places by more where there are more of them than
  /// nodes that yield. 0: its triangles as they are, places where it has vertices.
  double apart = 0;
  FineSize size;
  int most_nodes = 900;  ///< unknown ones; beyond it `size.flat` shrinks, then `size.edge` grows by a quarter, in turn

  bool operator==(const FineZoneOptions&) const = default;
  /// Of all places where it touches the least of what `of(place)` gives.
  template <class Of>
  double least(const Of& of) const {
    double out = of(centre);
    for (const Vec3& other : others) out = std::min(out, of(other));
    return out;
  }
  double distance(const Vec3& place) const {
    return least([&](const Vec3& c) { return (place - c).norm(); });
  }
};

/// A leaf: corners, then the middles of its edges in the order 01 12 20 03 13 23.
struct FineLeaf {
  std::array<int, 10> node;
  int cell;               ///< index in FineZone::cells
  int level;              ///< how often the cell was split
  bool is_empty = false;  ///< it holds no material: next to nothing, and what it has alone is held
};

/// Triangles of an embedded surface in the zone's leaves, long ones in pieces.
struct EmbeddedFacets {
  std::vector<int> triangle;             ///< of the body's surface, that each is a piece of; ascending
  std::vector<Triangle> facets;          ///< indices in `vertex`
  std::vector<CellPoint> vertex;         ///< where they are in the triangle
  std::vector<std::array<int, 4>> node;  ///< of the zone, that each vertex goes with, the field of the leaf taken as
                                         ///< linear between its nodes
  std::vector<std::array<double, 4>> weight;
  std::vector<int> leaf;       ///< of the zone, that each vertex is in
  std::vector<char> is_place;  ///< of each vertex: tools are held at it
  std::vector<int> places;     ///< these vertices, ascending: what yields by itself
  double apart = 0;            ///< none of the other vertices is further from a place on its side; 0: none is [m]
  /// Vertex v yields as places[near[k]] do with share[k], first_near[v] <= k < first_near[v+1]; a place by itself.
  std::vector<int> first_near, near;
  std::vector<double> share;
};

/// Topology of a zone; geometry comes with positions.
struct FineZone {
  std::vector<int> cells;        ///< of the body, ascending
  std::vector<int> inner;        ///< nodes of the body that only these cells hold and that may move, ascending
  std::vector<CellPoint> nodes;  ///< where they are in the coarse cells
  std::vector<FineLeaf> leaves;
  /// Node i follows unknown nodes from[k] with weight[k], first[i] <= k < first[i+1]: itself, or those that it hangs
  /// on; nothing: it is held.
  std::vector<int> first, from;
  std::vector<double> weight;
  std::vector<int> unknown;  ///< nodes; those of the surface in reach last
  int num_yielding = 0;      ///< how many are in reach; what tools are held at are these, or places between them
  std::vector<Triangle>
      facets;  ///< of the surface's triangles in reach, flat, counter-clockwise seen from outside: nodes
  std::vector<int> facet_triangle;  ///< of the body's surface, that each is a piece of; all pieces of it are there
  std::vector<char> facet_in_reach;
  EmbeddedFacets embedded;  ///< in the place of facets, of a surface that is embedded in the body's cells
  std::vector<std::vector<LeafPoint>> leaf_points;  ///< of leaves that a surface cuts, leaf_points(); none: whole ones
  double edge = 0;                                  ///< that was taken [m]
  double flat = 0;                                  ///< that was taken [m]
  double width = 0;                                 ///< `flat` that was asked for: of the contact and its way [m]
  double largest = 0;                               ///< leaf within it of where a tool touches [m]
  /// What R is of: yielding nodes, or places of an embedded surface.
  int num_points() const { return embedded.places.empty() ? num_yielding : static_cast<int>(embedded.places.size()); }
  int num_unknown() const { return static_cast<int>(unknown.size()); }
  std::span<const int> yielding() const { return std::span(unknown).last(static_cast<std::size_t>(num_yielding)); }
};

/// `edge` of the outcome is larger than that of the options where that would take too many nodes. Empty where not even
/// the cells as they are keep to that number, and where none is near.
FineZone make_fine_zone(const FineBody& body, const FineZoneOptions& options);

/// With size.edge as it is; empty where that takes too many nodes.
FineZone make_fine_zone_of_size(const FineBody& body, const FineZoneOptions& options);

}  // namespace kt
