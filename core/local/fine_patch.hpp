#pragma once
// The surface of refined cells over a patch (core/fine/), and how far it yields beyond what the patch's vertices do: a
// compliance R in series with the local model's, with the material's retardation.
#include <memory>
#include <utility>
#include <vector>

#include "core/body/mesh.hpp"
#include "core/body/node_weights.hpp"

namespace kt {

constexpr int kMostYielding = 10000;  ///< points of one patch: of two tools, refine_nodes at most each

struct FineOrigin;  // core/fine/make_fine_patch.hpp

/// A share of how far a vertex lies from its flat triangle, on a smooth surface over the body at rest. It turns with a
/// triangle of the body.
struct VertexOffset {
  int vertex = 0, triangle = 0;
  Vec3 along = Vec3::Zero();  ///< the columns of triangle_frame() [m]
};

/// Unit vectors: edge 01 of a triangle, across it in the plane, normal.
Mat3 triangle_frame(const Vec3& a, const Vec3& b, const Vec3& c) noexcept;

struct FinePatch {
  std::vector<Triangle> facets;  ///< vertices, counter-clockwise seen from outside
  std::vector<int> triangle;     ///< of the body's surface, that each is a piece of; ascending
  std::vector<Mat3> corners;     ///< of each facet: its corners as weights in that triangle, by columns
  std::vector<Mat3> to_facet;    ///< inverse of it: weights in the triangle to those in the facet
  /// Vertex i goes with nodes of the body node[k], with weight[k], first[i] <= k < first[i+1], and yields as yielding
  /// points from[k] with share[k], first_from[i] <= k < first_from[i+1], do; with none of them it does not yield.
  std::vector<int> first, node;
  std::vector<double> weight;
  std::vector<int> first_from, from;
  std::vector<double> share;
  std::vector<char> is_place;                ///< of each vertex: tools are held at it; empty: at all
  std::vector<VertexOffset> offsets;         ///< a vertex lies off its triangle by the sum of its own; none: flat
  double apart = 0;                          ///< none of the other vertices is further from one of those [m]
  std::vector<SurfacePlace> yielding;        ///< where the points are that yield by themselves, (y)
  MatrixX R;                                 ///< of these points [m/N], (3y x 3y), symmetric, positive semidefinite
  double retardation = 0;                    ///< [s]
  double width = 0;                          ///< of the contact that it was made for, and its way [m]
  double fineness = 0;                       ///< largest cell under the tool over the contact radius
  std::shared_ptr<const FineOrigin> origin;  ///< what it can be made from again; null: not kept

  int num_vertices() const noexcept { return static_cast<int>(first.size()) - 1; }
  int num_yielding() const noexcept { return static_cast<int>(yielding.size()); }
  /// The facet that holds a place, and the weights in it; -1: none of that triangle.
  std::pair<int, Vec3> find(const SurfacePlace& place) const noexcept;
  /// The nodes of the body that move a point of a facet.
  NodeWeights moved_by(int facet, const Vec3& bary) const noexcept;
  /// The yielding points that it yields with: indices of R's blocks.
  NodeWeights yields_with(int facet, const Vec3& bary) const noexcept;
};

/// How far the points of `now` had yielded on another patch of the same body, by their places; zero where that one did
/// not yield. No allocation.
/// @param old    null: nothing had        @param z  of its points [m], (3y) or longer
/// @param out    (3y) of `now`
void carry_yield(const FinePatch* old, const VectorX& z, const FinePatch& now, VectorX& out) noexcept;

}  // namespace kt
