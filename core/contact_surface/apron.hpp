#pragma once
// The body's surface around a patch, for a tool that gets there before the next local model does: it would meet nothing
// and be inside the body when that comes. The apron is coarse: it goes with the patch's vertices, so that it yields to
// a tool about as the patch does and no contact there creates energy. What a load on the patch has moved is taken out:
// a tool that leaves its dent finds the surface beside it where it is without the load. A contact there is flagged
// (kOnApron), and asks for a new local model.
#include "core/body/node_weights.hpp"
#include "core/contact_surface/contact_surface.hpp"
#include "core/local/reducer.hpp"

namespace kt {

/// How each node of the body's surface outside a patch goes with it: x = at + mean(u), where u are the displacements of
/// the patch's vertices since the linearization, and mean(u) is that of the place where the tool was. A node that went
/// partly with the patch's nearest vertex would be stiffer than both: 1 / (a² + b²) times for shares a, b.
struct ApronMotion {
  std::vector<int> patch_vertex;  ///< of each node of the body: the patch's vertex that answers to loads, or -1
  VectorX at;                     ///< of each node, while the patch is where it was linearized [m], (3n)
  std::vector<signed char> site;  ///< of each node: whose mean it goes with; -1: it cannot move
  std::vector<NodeWeights> mean;  ///< of each site
  VectorX patch_at;               ///< the patch where it was linearized [m], (3p)
  double lowered = 0;             ///< most that a node's `at` is from where it was linearized [m]

  /// mean(u) of each site, for place().
  void means(const VectorX& patch_x, std::span<Vec3> out) const noexcept;
  Vec3 place(int node, std::span<const Vec3> means) const noexcept;
};

struct ApronOptions {
  VectorX patch_x;                 ///< the patch's vertices where it was linearized [m], (3p)
  std::span<const char> moves;     ///< of each patch vertex: it can
  std::span<const char> answers;   ///< of each patch vertex: the local model has its own response to a load on it alone
  std::span<const char> is_fixed;  ///< of each node of the body
  double radius = 0;               ///< of the largest tool's rounding [m]
  VectorX unloaded;                ///< the patch's displacement when what touches it lets go [m], (3p); empty: 0
};

/// @param x  of the whole body where it was linearized [m], (3n)
ApronMotion make_apron_motion(const Surface& surface, const VectorX& x, const ContactSite& site,
                              const SurfacePatch& patch, const ApronOptions& options);

/// Corners of the patch's facets that have no response of their own become the apron's: a basis of responses holds what
/// a load on all of the rim does, and to a load on one corner of it alone that is several times too stiff. Not of a
/// smooth patch, which has a response to each of its nodes. Once, before the room is made.
void give_rim_to_apron(const ApronMotion& motion, const SurfacePatch& patch, ContactSurface& out);

/// Room for append_apron(), and where a contact surface ends without an apron.
struct ApronRoom {
  ApronRoom() = default;
  /// Takes all memory that up to so many triangles with so many vertices need, in `out`, too.
  ApronRoom(int nodes, int most_triangles, int most_vertices, ContactSurface& out);
  std::size_t triangles = 0, vertices = 0, followed = 0, moved = 0;
  int most_triangles = 0, most_vertices = 0;
  std::vector<int> vertex_of_node;  // -1 between calls
  TopologyRoom topology;
};

/// Makes these triangles of the body, ascending, the apron of the surface that tools touch, instead of the one that is
/// there. No allocation.
/// @param patch  that `out` was made of
void append_apron(const Surface& surface, const ApronMotion& motion, const SurfacePatch& patch,
                  std::span<const int> triangles, ApronRoom& room, ContactSurface& out) noexcept;

}  // namespace kt
