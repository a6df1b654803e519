#pragma once
// The surface that tools touch: the patch's own triangles, a smoother one over them whose vertices are weighted means
// of the patch's, or facets of refined cells, which may be raised from their triangles. Its velocities are linear in
// those of the nodes, so that a force on it and the motion it causes belong together: no contact creates energy.
#include <span>

#include "core/base/backend.hpp"
#include "core/body/node_weights.hpp"
#include "core/local/fine_patch.hpp"
#include "core/local/local_model.hpp"
#include "core/local/reducer.hpp"

namespace kt {

/// How smooth; "flat": the triangles themselves.
struct Smoothing {
  std::string scheme = "flat";  ///< contact_surface_backends()
  int levels = 0;               ///< each splits a triangle in four; 0: flat
};

std::vector<BackendInfo> contact_surface_backends();

constexpr std::size_t kMostApronSites = 4;  ///< of one patch

/// What a vertex of the apron goes with (apron.hpp): a vertex of the patch, or the mean of a site; neither: it stays.
struct ApronVertex {
  int patch_vertex = -1, site = -1;
};

struct ContactSurface {
  /// As if it were a patch of the body; global_triangle is that which a facet is a piece of, nodes have no number.
  SurfacePatch facets;
  int levels = 0;
  int num_nodes = 0;         ///< of the patch
  bool is_embedded = false;  ///< its vertices are embedded in the cells of the patch's nodes
  /// Refined triangles: each patch triangle's own facet is the first of its pieces, the others come after all patch
  /// triangles. What moves the surface then goes on, after the patch's vertices, with how far its points have yielded.
  std::shared_ptr<const FinePatch> fine;
  std::vector<int> fine_facet;     ///< of each facet but the apron's: of the fine patch, -1: a triangle as it is
  std::vector<char> is_place;      ///< of each vertex of refined facets: tools are held at it; empty: at all
  std::vector<int> facet_of_fine;  ///< of each facet of the fine patch; -1: its triangle is not refined
  /// Who moves with facet t: patch vertices moved_node[k] with moved_weight[k] of its three corners, first_moved[t] <=
  /// k < first_moved[t+1].
  std::vector<int> first_moved, moved_node;
  std::vector<Vec3> moved_weight;
  std::vector<int> first, from;  ///< see Subdivision
  std::vector<double> weight;
  /// Facets and vertices from these on are the apron's (apron.hpp): triangles of the body in one piece each. -1: none.
  int apron_facets = -1, apron_vertices = -1;
  std::vector<ApronVertex> apron;        ///< the same as `weight` says, in what a tick is quick with
  std::vector<NodeWeights> apron_means;  ///< of each site
  VectorX apron_offset;                  ///< of their positions from what `weight` gives [m]; may have room for more
  std::vector<char> rim_of_apron;        ///< of each facet of the patch: corners of it are the apron's; empty: of none

  /// Of refined vertices that lie on a smooth surface, from where follow() has them [m], (3n) or empty. Not of those at
  /// the edge of what is refined, which join the flat triangles.
  VectorX offset;

  /// Positions of its vertices but the apron's from those of the patch's. No allocation.
  void place(const VectorX& patch, VectorX& out) const noexcept;
  /// Their velocities; for positions, place(). No allocation.
  void follow(const VectorX& patch, VectorX& out) const noexcept;
  /// The same of the apron's alone: their velocities.
  void follow_apron(const VectorX& patch, VectorX& out) const noexcept;
  /// Their positions.
  void place_apron(const VectorX& patch, VectorX& out) const noexcept;
  /// Of the point of a facet. No allocation.
  Vec3 at(const VectorX& patch, int facet, const Vec3& bary) const noexcept;
  void add_at(VectorX& patch, int facet, const Vec3& bary, const Vec3& value) const noexcept;
  /// The patch vertices that move it.
  NodeWeights moved_by(int facet, const Vec3& bary) const noexcept;
  /// The same as nodes of the body.
  NodeWeights moved_by(const SurfacePatch& patch, int facet, const Vec3& bary) const noexcept;

  int num_yielding() const noexcept { return fine ? fine->num_yielding() : 0; }
  /// Of vectors that move it: patch vertices, then yielding points.
  int num_moving() const noexcept { return num_nodes + num_yielding(); }
  int facets_per_triangle() const { return 1 << (2 * levels); }
  /// Numbers that stay from patch to patch: piece of the body's triangle.
  int global_facet(int facet) const noexcept {
    return facets.global_triangle[facet] * facets_per_triangle() + piece(facet);
  }
  bool is_apron(int facet) const noexcept { return apron_facets >= 0 && facet >= apron_facets; }
  /// Whether it moves as the apron does, not with the nodes of its triangle.
  bool goes_with_apron(int facet) const noexcept {
    return is_apron(facet) || (!rim_of_apron.empty() && rim_of_apron[facet]);
  }
  int piece(int facet) const noexcept { return is_apron(facet) ? 0 : facet % facets_per_triangle(); }
  /// Of the body's triangle, from those of a facet.
  Vec3 weights_in_triangle(int facet, const Vec3& bary) const noexcept;
  bool is_refined(int facet) const noexcept { return fine && !is_apron(facet) && fine_facet[facet] >= 0; }
  SurfacePlace place_of(int facet, const Vec3& bary) const noexcept {
    return {facets.global_triangle[facet], weights_in_triangle(facet, bary)};
  }
  /// The facet that holds a place, and the weights in it.
  /// @param triangle  of the patch: that of the place
  std::pair<int, Vec3> facet_at(int triangle, const SurfacePlace& place) const noexcept;
};

struct CouplingRoom {
  explicit CouplingRoom(int vertices = 0) : sum(vertices), point(vertices) {}
  std::vector<Mat3> sum;   ///< how each vertex moves with one point
  std::vector<int> point;  ///< which
};

/// J C J^T (3n x 3n) of n points that move with the patch's vertices, for a symmetric matrix C (3p x 3p) of the patch.
/// On a smooth surface points share most of their vertices: what a vertex has to do with a point is summed once. No
/// allocation.
void couple_points(const MatrixX& C, std::span<const NodeWeights> points, CouplingRoom& room,
                   Eigen::Ref<MatrixX> out) noexcept;

/// Throws InputError for an unknown scheme.
/// @param fine  over a flat surface only; null: none
ContactSurface make_contact_surface(const SurfacePatch& patch, const Smoothing& smoothing,
                                    std::shared_ptr<const FinePatch> fine = nullptr);

/// Fills surface.offset from the fine patch's offsets, which have turned with the triangles.
/// @param x  of the patch's vertices [m], (3n)
void turn_offsets(const SurfacePatch& patch, const VectorX& x, ContactSurface& surface);

/// The nodes of the body that move a point of its smooth surface.   bary: weights in the triangle
NodeWeights moved_by(const Surface& surface, const Smoothing& smoothing, int triangle, const Vec3& bary);

/// The point of the triangle that `bary` of its piece is.
Vec3 weights_in_triangle(int piece, int levels, const Vec3& bary);
/// The piece that holds the point of a triangle, and the weights in it.
std::pair<int, Vec3> piece_at(int levels, const Vec3& bary);

}  // namespace kt
