// CGAL Mesh_3 (GPL-3): makes a new surface near the old one, with sharp edges kept.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"  // false, about Boost's graph edges, reported at the end of file
#endif
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_polyhedron_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polyhedral_mesh_domain_with_features_3.h>
#include <CGAL/Random.h>
#include <CGAL/make_mesh_3.h>

#include <cmath>
#include <unordered_map>

#include "core/base/error.hpp"
#include "io/solid/tetrahedralize_backends.hpp"

namespace kt {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Polyhedron = CGAL::Mesh_polyhedron_3<Kernel>::type;
using Domain = CGAL::Polyhedral_mesh_domain_with_features_3<Kernel>;
using Triangulation = CGAL::Mesh_triangulation_3<Domain, CGAL::Default, CGAL::Sequential_tag>::type;
using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation, Domain::Corner_index, Domain::Curve_index>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;

Polyhedron polyhedron(const Mesh& surface) {
  std::vector<Kernel::Point_3> points;
  std::vector<std::array<std::size_t, 3>> faces;
  for (int i = 0; i < surface.num_nodes(); ++i)
    points.emplace_back(surface.x[3 * i], surface.x[3 * i + 1], surface.x[3 * i + 2]);
  for (const Triangle& t : surface.triangles)
    faces.push_back({static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]), static_cast<std::size_t>(t[2])});
  Polyhedron out;
  CGAL::Polygon_mesh_processing::polygon_soup_to_polygon_mesh(points, faces, out);
  return out;
}

/// Runs in the child.
Mesh fill(const Mesh& surface, const TetrahedralizeOptions& options) {
  CGAL::get_default_random() = CGAL::Random(0);  // the same mesh every time
  const Polyhedron input = polyhedron(surface);
  Domain domain(input);
  constexpr double kSharp = 60;  // degrees between normals
  domain.detect_features(kSharp);
  const double edge = std::cbrt(6 * std::sqrt(2.0) * options.max_volume);
  namespace par = CGAL::parameters;
  const Criteria criteria(par::edge_size = edge, par::facet_angle = 25, par::facet_size = 0.7 * edge,
                          par::facet_distance = 0.05 * edge,
                          par::cell_radius_edge_ratio = std::max(2.0, options.quality), par::cell_size = 0.7 * edge);
  const Complex complex = CGAL::make_mesh_3<Complex>(domain, criteria);
  Mesh out;
  std::vector<double> x;
  std::unordered_map<Triangulation::Vertex_handle, int> number;
  for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end(); ++cell) {
    Tetrahedron t{};
    for (int k = 0; k < 4; ++k) {
      const auto vertex = cell->vertex(k);
      const auto [it, fresh] = number.try_emplace(vertex, static_cast<int>(number.size()));
      if (fresh)
        for (int c = 0; c < 3; ++c) x.push_back(vertex->point()[c]);
      t[k] = it->second;
    }
    out.tetrahedra.push_back(t);
  }
  out.x = Eigen::Map<const VectorX>(x.data(), static_cast<Eigen::Index>(x.size()));
  return out;
}

}  // namespace

Mesh tetrahedralize_cgal(const Mesh& surface, const TetrahedralizeOptions& options) {
  return fill_in_child("cgal", surface, options, fill);
}

}  // namespace kt
