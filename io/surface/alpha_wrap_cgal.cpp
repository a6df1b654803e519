// Wraps a triangle soup with a closed surface, and measures how far it is from what it wraps.
#define CGAL_NO_DEPRECATION_WARNINGS  // CGAL 6 has other names for these headers, CGAL 5 only these
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>

#include <cmath>

#include "io/mesh/edge_table.hpp"
#include "io/surface/repair_cgal.hpp"

namespace kt {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;

Point point(const Mesh& mesh, int i) { return {mesh.x[3 * i], mesh.x[3 * i + 1], mesh.x[3 * i + 2]}; }

}  // namespace

Mesh alpha_wrap_cgal(const Mesh& surface, double alpha, double offset) {
  std::vector<Point> points;
  std::vector<std::array<std::size_t, 3>> faces;
  for (int i = 0; i < surface.num_nodes(); ++i) points.push_back(point(surface, i));
  for (const Triangle& t : surface.triangles)
    if (!is_degenerate(surface.x, t))
      faces.push_back({static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]), static_cast<std::size_t>(t[2])});
  CGAL::Surface_mesh<Point> wrapped;
  CGAL::alpha_wrap_3(points, faces, alpha, offset, wrapped);
  wrapped.collect_garbage();
  Mesh out;
  out.x.resize(3 * static_cast<Eigen::Index>(wrapped.number_of_vertices()));
  for (const auto v : wrapped.vertices())
    for (int k = 0; k < 3; ++k) out.x[3 * static_cast<Eigen::Index>(v.idx()) + k] = wrapped.point(v)[k];
  for (const auto f : wrapped.faces()) {
    Triangle t{};
    int k = 0;
    for (const auto v : wrapped.vertices_around_face(wrapped.halfedge(f))) t[k++] = static_cast<int>(v.idx());
    out.triangles.push_back(t);
  }
  return out;
}

double sampled_distance_cgal(const Mesh& from, const Mesh& to, double spacing) {
  using Iterator = std::vector<Kernel::Triangle_3>::const_iterator;
  using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, CGAL::AABB_triangle_primitive<Kernel, Iterator>>>;
  std::vector<Kernel::Triangle_3> triangles;
  for (const Triangle& t : to.triangles)
    if (!is_degenerate(to.x, t)) triangles.emplace_back(point(to, t[0]), point(to, t[1]), point(to, t[2]));
  if (triangles.empty()) return 0;
  const Tree tree(triangles.begin(), triangles.end());
  double largest_sq = 0;
  for (const Triangle& t : from.triangles) {
    const Vec3 a = node(from.x, t[0]), ab = node(from.x, t[1]) - a, ac = node(from.x, t[2]) - a;
    const double longest = std::max({ab.norm(), ac.norm(), (ab - ac).norm()});
    const int n = std::max(1, std::min(64, static_cast<int>(std::ceil(longest / spacing))));
    for (int i = 0; i <= n; ++i)
      for (int j = 0; i + j <= n; ++j) {
        const Vec3 p = a + ab * (double(i) / n) + ac * (double(j) / n);
        largest_sq = std::max(largest_sq, tree.squared_distance({p[0], p[1], p[2]}));
      }
  }
  return std::sqrt(largest_sq);
}

}  // namespace kt
