#pragma once
// The patch that errors and times of local models are measured on.
#include "core/local/reducer.hpp"

namespace kt {

/// All triangles around the vertex and around its neighbours: 19 vertices on a regular surface.
inline SurfacePatch two_rings(const Surface& surface, int vertex) {
  std::vector<char> near(surface.topology.first.size() - 1, 0), inside(surface.triangles.size(), 0);
  for (int t : surface.topology.triangles_of(vertex))
    for (int i : surface.triangles[t]) near[i] = 1;
  std::vector<int> local(near.size(), -1);
  for (std::size_t t = 0; t < inside.size(); ++t)
    for (int i : surface.triangles[t]) inside[t] |= near[i];
  SurfacePatch patch;
  for (int i = 0; i < static_cast<int>(near.size()); ++i)
    for (int t : surface.topology.triangles_of(i))
      if (inside[t] && local[i] < 0) {
        local[i] = patch.num_vertices();
        patch.global_node.push_back(i);
      }
  for (int t = 0; t < static_cast<int>(inside.size()); ++t) {
    if (!inside[t]) continue;
    const Triangle& g = surface.triangles[t];
    patch.triangles.push_back({local[g[0]], local[g[1]], local[g[2]]});
    patch.global_triangle.push_back(t);
    patch.on_rim.push_back(0);
  }
  patch.in_reach.assign(patch.global_node.size(), 1);
  patch.topology = make_topology(patch.triangles, patch.num_vertices());
  return patch;
}

}  // namespace kt
