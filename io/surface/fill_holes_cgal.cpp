// Closes small holes with CGAL's hole triangulation over the border nodes: no new nodes, so the rest stays as it is.
#define CGAL_NO_DEPRECATION_WARNINGS  // CGAL 6 asks for a parameter that CGAL 5 does not have
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>

#include "core/base/error.hpp"
#include "io/mesh/edge_table.hpp"
#include "io/surface/repair_cgal.hpp"

namespace kt {

int fill_holes_cgal(Mesh& surface, int max_edges) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;
  using Vertex = SurfaceMesh::Vertex_index;
  using Face = SurfaceMesh::Face_index;
  SurfaceMesh mesh;
  for (int i = 0; i < surface.num_nodes(); ++i)
    mesh.add_vertex({surface.x[3 * i], surface.x[3 * i + 1], surface.x[3 * i + 2]});
  for (const Triangle& t : surface.triangles) {
    const auto vertex = [](int i) { return Vertex(static_cast<SurfaceMesh::size_type>(i)); };
    if (mesh.add_face(vertex(t[0]), vertex(t[1]), vertex(t[2])) == SurfaceMesh::null_face())
      throw InputError(text("filling holes: the surface is not manifold at triangle ", t[0], " ", t[1], " ", t[2]));
  }
  std::vector<SurfaceMesh::Halfedge_index> borders;
  CGAL::Polygon_mesh_processing::extract_boundary_cycles(mesh, std::back_inserter(borders));
  int filled = 0;
  for (const auto border : borders) {
    int edges = 0;
    for (auto h = border; edges <= max_edges;) {
      ++edges;
      h = mesh.next(h);
      if (h == border) break;
    }
    if (edges > max_edges) continue;
    std::vector<Face> faces;
    CGAL::Polygon_mesh_processing::triangulate_hole(mesh, border, std::back_inserter(faces));
    for (const Face f : faces) {
      Triangle t{};
      int k = 0;
      for (const Vertex v : mesh.vertices_around_face(mesh.halfedge(f))) t[k++] = static_cast<int>(v.idx());
      surface.triangles.push_back(t);
    }
    filled += !faces.empty();
  }
  return filled;
}

}  // namespace kt
