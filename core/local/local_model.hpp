#pragma once
// What the haptic side gets at each refresh: a small linear body around the contact, and the surface it carries.
#include <limits>
#include <memory>
#include <string>

#include "core/base/types.hpp"
#include "core/body/surface.hpp"

namespace kt {

/// The vertices of a patch's triangles where these are embedded in cells: vertex i moves with the patch's nodes from[k]
/// by weight[k], first[i] <= k < first[i+1].
struct EmbeddedPatch {
  std::vector<int> global_vertex;  ///< of each vertex: its number among the body's nodes
  std::vector<int> first{0}, from;
  std::vector<double> weight;
};

/// The piece of surface that the tool can reach before the next refresh. Vertices are numbered locally.
struct SurfacePatch {
  std::vector<Triangle> triangles;   ///< local vertex indices; of an embedded surface those of `embedded`
  std::vector<int> global_triangle;  ///< of each local triangle
  std::vector<int> global_node;      ///< of each local vertex, (p)
  std::vector<char> on_rim;          ///< per triangle: it touches the edge of the patch, not of the body
  SurfaceTopology topology;
  std::vector<std::array<int, 3>> wall;       ///< see find_walls(): of the body at rest, not of its dents
  std::vector<std::array<Crease, 3>> crease;  ///< of its edges, of the body at rest; empty: none
  /// Vertices that a tool within reach touches: not those of rim triangles alone, which are there for the normals. (p)
  std::vector<char> in_reach;
  bool is_curved = false;  ///< triangles are pieces of a smooth surface: forces act along its normals
  std::shared_ptr<const EmbeddedPatch> embedded = {};  ///< none: the triangles' vertices are nodes
  int num_vertices() const { return static_cast<int>(global_node.size()); }
};

struct FinePatch;

/// mass q'' = f0 - stiffness q - damping q' + forces;  recovered node displacement u = basis q.
struct LocalModel {
  int frame = 0;  ///< counts refreshes
  double t = 0;   ///< of the linearization [s]
  SurfacePatch patch;
  std::vector<int> recovered_node;  ///< global nodes whose motion `basis` recovers; the first p are the patch's
  VectorX x0, v0;                   ///< their positions [m] and velocities [m/s] at the linearization
  SparseMatrix basis;               ///< (3 recovered x r); zero rows: the node is immovable
  /// The coordinates of given displacements and velocities of the recovered nodes, (r x 3 recovered): basis lift = 1 on
  /// the rows that can move and are in reach; the columns of the others are zero where they only follow. The rest of
  /// the body follows statically, or as its inertia lets it.
  SparseMatrix lift, lift_rate;
  /// The same for motions of another model, which this basis may follow node by node only by wild motion of all else:
  /// each node yields, as if pulled by a spring (a mass) a thousand times its own, so that these motions take no more
  /// than 250 times the energy of moving each node by itself, all else held. (r x 3 recovered)
  SparseMatrix fit, fit_rate;
  SparseMatrix mass, damping, stiffness;  ///< (r x r), symmetric; mass > 0
  VectorX f0;                             ///< force at q = 0, q' = 0 [N], (r)
  VectorX q_rate0;                        ///< reduced velocity at the linearization, (r)
  bool definite_tangent = false;          ///< the exact tangent was indefinite here and has been clamped
  std::string reducer;
  double certified_error = std::numeric_limits<double>::quiet_NaN();  ///< relative, 0-500 Hz; NaN: not certified
  std::shared_ptr<const FinePatch> fine;  ///< refined cells around the contact (fine_patch.hpp); none: as they are
  int dof() const { return static_cast<int>(f0.size()); }
};

}  // namespace kt
