#pragma once
// Who neighbours whom on a triangle surface. Built once per mesh or patch from raw index buffers, so non-manifold and
// duplicate triangles are allowed.
#include <span>
#include <vector>

#include "core/types.hpp"

namespace kt {

/// Compressed rows: triangles around each node, and the triangle across each edge.
struct SurfaceTopology {
  std::vector<int> first, fan;             ///< triangles of node i: fan[first[i]] .. fan[first[i+1]-1], ascending
  std::vector<std::array<int, 3>> across;  ///< triangle over edge (v[i], v[(i+1)%3]); -1 open, -2 non-manifold
  std::span<const int> triangles_of(int node) const {
    return {fan.data() + first[node], static_cast<std::size_t>(first[node + 1] - first[node])};
  }
};

SurfaceTopology make_topology(std::span<const Triangle> triangles, int num_nodes);

}  // namespace kt
