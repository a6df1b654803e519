// Edge collapse with the costs and places of Lindstrom and Turk.
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_filter.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_cost.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_placement.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include "core/error.hpp"
#include "io/decimate_surface.hpp"

namespace kt {
namespace {

namespace sms = CGAL::Surface_mesh_simplification;
using Surface = CGAL::Surface_mesh<CGAL::Simple_cartesian<double>::Point_3>;

Surface to_cgal(const Mesh& mesh) {
  Surface out;
  std::vector<Surface::Vertex_index> vertices;
  for (int i = 0; i < mesh.num_nodes(); ++i)
    vertices.push_back(out.add_vertex({mesh.x[3 * i], mesh.x[3 * i + 1], mesh.x[3 * i + 2]}));
  for (const Triangle& t : mesh.triangles)
    if (out.add_face(vertices[t[0]], vertices[t[1]], vertices[t[2]]) == Surface::null_face())
      throw RunError("the surface is not manifold");
  return out;
}

}  // namespace

Mesh decimate_cgal(const Mesh& surface, int triangles) {
  Surface mesh = to_cgal(surface);
  // Edges are what the stop counts: three for two triangles of a closed surface.
  const sms::Count_stop_predicate<Surface> stop(static_cast<std::size_t>(triangles) * 3 / 2);
  sms::edge_collapse(mesh, stop,
                     CGAL::parameters::get_cost(sms::LindstromTurk_cost<Surface>())
                         .get_placement(sms::LindstromTurk_placement<Surface>())
                         .filter(sms::Bounded_normal_change_filter<>()));
  mesh.collect_garbage();
  Mesh out;
  out.x.resize(3 * static_cast<Eigen::Index>(mesh.number_of_vertices()));
  for (const auto v : mesh.vertices())
    for (int k = 0; k < 3; ++k) out.x[3 * static_cast<Eigen::Index>(v.idx()) + k] = mesh.point(v)[k];
  for (const auto f : mesh.faces()) {
    Triangle t{};
    int k = 0;
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(f))) t[k++] = static_cast<int>(v.idx());
    out.triangles.push_back(t);
  }
  return out;
}

}  // namespace kt
