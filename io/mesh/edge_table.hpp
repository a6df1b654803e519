#pragma once
// Edges of a triangle soup: allows anything (three faces on an edge, duplicates, open borders).
#include <array>
#include <span>
#include <vector>

#include "core/base/types.hpp"

namespace kt {

struct Edge {
  int a = 0, b = 0;          ///< nodes, a < b
  int first = 0, count = 0;  ///< its uses: EdgeTable::uses[first .. first+count)
};
struct EdgeUse {
  int triangle = 0, side = 0;  ///< from corner `side` to corner (side+1)%3
  bool forward = true;         ///< a to b
};

/// All edges in order of (a, b). Triangles that repeat a node are left out: they have no three edges.
struct EdgeTable {
  std::vector<Edge> edges;
  std::vector<EdgeUse> uses;
  std::vector<std::array<int, 3>> edge_of;  ///< edge of every side of every triangle; -1 for triangles left out
  std::span<const EdgeUse> uses_of(const Edge& e) const {
    return {uses.data() + e.first, static_cast<std::size_t>(e.count)};
  }
};

EdgeTable make_edge_table(std::span<const Triangle> triangles);

/// True when the triangle has the same node at two corners.
inline bool repeats_node(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

/// True when the triangle has no area: a repeated node, equal positions, or a height below the rounding of its longest
/// edge. Triangles with non-finite corners are not called degenerate.
bool is_degenerate(const VectorX& x, const Triangle& t);

/// Number of the piece each triangle belongs to (pieces hang together over edges, in order of their first triangle),
/// and whether a triangle's orientation must be reversed to agree with its piece's first one.
struct Pieces {
  int count = 0;
  std::vector<int> piece;       ///< per triangle; -1 for triangles that the edge table leaves out
  std::vector<bool> reversed;   ///< per triangle
  std::vector<bool> one_sided;  ///< per piece: cannot be oriented (Moebius strip); `reversed` is then arbitrary
};
/// With `through_nonmanifold`, edges of three or more triangles connect too (but carry no orientation).
Pieces find_pieces(std::span<const Triangle> triangles, const EdgeTable& table, bool through_nonmanifold);

/// Fans of triangles around every node, joined over the edges at the node: manifold nodes have at most one.
/// fan_of[t][k] is the number of the fan at corner k of triangle t, from 0.
struct Fans {
  std::vector<int> count;                  ///< per node
  std::vector<std::array<int, 3>> fan_of;  ///< per triangle
};
Fans find_fans(std::span<const Triangle> triangles, const EdgeTable& table, int num_nodes);

}  // namespace kt
