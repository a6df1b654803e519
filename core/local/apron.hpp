#pragma once
// The body's surface around a patch, for a tool that gets there before the next local model does: it would meet nothing
// and be inside the body when that comes. The apron is coarse: each of its nodes goes with the patch's nearest ones, so
// that it yields to a tool about as the patch does, and moves with the body as the patch does. A contact there is
// flagged (kLeftPatch), and asks for a new local model.
#include "core/local/contact_surface.hpp"
#include "core/local/reducer.hpp"

namespace kt {

struct Apron {
  std::vector<int> global_triangle;  ///< of the body, ascending; none of the patch's
  std::vector<Triangle> triangles;   ///< of the patch's vertices, then of its own
  std::vector<int> global_node;      ///< of its own vertices
  VectorX x;                         ///< where these were when the body was linearized [m]
  /// Vertex i of its own moves as the patch's vertices from[k], by weight[k], first[i] <= k < first[i+1]; their sum is
  /// 1, or 0 where it cannot move.
  std::vector<int> first, from;
  std::vector<double> weight;
};

/// The triangles nearest to the tools' sites that are not in the patch, connected or not: the other side of a fold,
/// too.
/// @param x           of the whole body where it was linearized [m], (3n)
/// @param moves       of each patch vertex: it can
/// @param is_fixed    of each node of the body
/// @param most        triangles
Apron make_apron(const Surface& surface, const VectorX& x, const ContactSite& site, const SurfacePatch& patch,
                 const std::vector<char>& moves, const std::vector<char>& is_fixed, int most);

/// Adds the apron to the surface that tools touch.
/// @param patch    that `out` was made of      @param patch_x  its vertices, where the body was linearized [m]
void add_apron(const Apron& apron, const Surface& surface, const SurfacePatch& patch, const VectorX& patch_x,
               ContactSurface& out);

}  // namespace kt
