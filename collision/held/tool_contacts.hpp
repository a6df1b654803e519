#pragma once
// Where a tool of any shape but a point touches a surface at rest: the contacts that the solver holds as constraints.
#include "collision/held/moving_tool.hpp"
#include "collision/held/surface_contacts.hpp"

namespace kt {

/// Which features of a tool and a surface are near each other: found once in a tick, and looked at again while the
/// surface moves little. Of one tool and one surface. All memory is taken at construction.
struct NearFeatures {
  struct CornerFace {
    int corner, triangle;
  };
  struct EdgeEdge {
    int tool_edge, triangle, edge;  ///< tool_edge: of ToolFeatures; the surface's by its first triangle
  };
  struct FaceVertex {
    int face, vertex;
  };
  NearFeatures() = default;
  NearFeatures(int num_facets, int num_vertices);

  bool is_known =
      false;         ///< false: candidates or tool are others than before, or there were more than there is room for
  double slack = 0;  ///< they hold as long as no vertex has moved further [m]
  VectorX x;         ///< the surface when they were found, (3 vertices)
  std::vector<int> vertices;
  std::vector<CornerFace> corner_faces;
  std::vector<EdgeEdge> edge_edges;
  std::vector<FaceVertex> face_vertices;
  std::vector<char> is_candidate, is_seen;  ///< of facets, of vertices: false outside find_tool_contacts()
};

/// Contacts with a gap below `margin` [m], among `candidates` (triangles, ascending) and their neighbours, seen from
/// outside.
///
/// A sphere about any place of the core is part of the tool, so that it must not get into the surface is always true.
/// The places are: each corner of the core that sticks out (ToolFeatures); where one of its edges is nearest to an edge
/// of the surface; where one of its sides is nearest to a vertex of the surface. Each has the contacts of its sphere
/// (find_sphere_contacts()), and each pair of features is looked at once, not once for each triangle it belongs to.
/// `start` (or -1): a triangle touched before; a corner that has gone through the surface there is pushed out.
/// `way` [m]: that the tool has come since it was outside, as in find_sphere_contacts().
/// `overlap` [m]: that it may have besides, as one that is pushed out.
/// `near`: must not be known when candidates or tool have changed; it changes no contact.
void find_tool_contacts(const SurfacePatch& patch, const VectorX& x, const ToolCore& core, double radius, double margin,
                        std::span<const int> candidates, int start, NearFeatures& near, ContactSet& out,
                        const Vec3& way = Vec3::Zero(), double overlap = 0) noexcept;

}  // namespace kt
