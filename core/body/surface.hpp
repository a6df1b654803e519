#pragma once
// The body's surface: its triangles, who neighbours whom, where it is creased. Built once per mesh or patch from raw
// index buffers, so non-manifold and duplicate triangles are allowed.
#include <span>
#include <vector>

#include "core/body/mesh.hpp"

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

/// What a topology is made with.
struct TopologyRoom {
  struct Edge {
    int low, high, triangle, corner;
  };
  void reserve(std::size_t triangles, std::size_t nodes);
  std::vector<int> next;
  std::vector<Edge> edges;
};
/// The same; no allocation where room and `out` have had so many triangles and nodes before, or reserved for them.
void make_topology(std::span<const Triangle> triangles, int num_nodes, TopologyRoom& room, SurfaceTopology& out);

enum class Crease : char { none, ridge, groove };

/// Of each edge (v[i], v[i+1]) of each triangle: ridges are convex edges over which the faces' normals turn by more
/// than `ridge_angle`, grooves concave ones with more than 45 degrees.
/// @param x            positions at rest [m], (3n)
/// @param ridge_angle  [rad]
std::vector<std::array<Crease, 3>> find_creases(std::span<const Triangle> triangles, const VectorX& x,
                                                const SurfaceTopology& topology, double ridge_angle);

/// Walls of grooves: where faces meet at more than 45 degrees over a concave edge, they are two walls and no round
/// hollow. Of each triangle, for each of its corners: the number of its wall among the triangles around that vertex,
/// which is the same unless grooves part them. Empty when there is no groove.        x: positions at rest [m], (3n)
std::vector<std::array<int, 3>> find_walls(std::span<const Triangle> triangles, const VectorX& x,
                                           const SurfaceTopology& topology);

/// The same from the edges (v[i], v[i+1]) that are grooves.
std::vector<std::array<int, 3>> number_walls(std::span<const Triangle> triangles,
                                             std::span<const std::array<bool, 3>> groove,
                                             const SurfaceTopology& topology);

constexpr double kRidgeAngle = 1.0471975511965976;  ///< [rad] 60 degrees

/// The body's surface: triangles (global node indices), who neighbours whom, and its grooves at rest.
struct Surface {
  std::vector<Triangle> triangles;
  SurfaceTopology topology;
  std::vector<std::array<int, 3>> wall;                  ///< see find_walls()
  std::vector<std::array<Crease, 3>> crease;             ///< see find_creases()
  std::shared_ptr<const EmbeddedSurface> embedded = {};  ///< in the body's cells; none: its vertices are nodes
};
/// @param ridge_angle  convex edges with a larger one stay sharp on a smooth contact surface [rad]
Surface make_surface(const Mesh& mesh, double ridge_angle = kRidgeAngle);

}  // namespace kt
