// Edge collapse with the quadrics of Garland and Heckbert, refused where it would leave slivers; evenly with those of
// Trettner and Kobbelt.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"  // false: quadrics are set after the map of them is made
#endif
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_filter.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_plane_policies.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_probabilistic_plane_policies.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.hpp"
#include "io/surface/decimate_surface.hpp"
#include "io/surface/refine_surface.hpp"

namespace kt {
namespace {

namespace sms = CGAL::Surface_mesh_simplification;
using Kernel = CGAL::Simple_cartesian<double>;
using Point = Kernel::Point_3;
using Surface = CGAL::Surface_mesh<Point>;
using Variances = CGAL::Constant_property_map<Surface::Face_index, std::pair<double, double>>;
using Quadrics = sms::GarlandHeckbert_plane_policies<Surface, Kernel>;
using EvenQuadrics = sms::GarlandHeckbert_probabilistic_plane_policies<Surface, Kernel, Variances>;

// Of triangles that are left. Higher ones cost distance: at 0.3 an elephant is 2 % and a torus 2.6 times as far off.
constexpr double kLeastShapes[] = {0.2, 0.05, 0};
constexpr double kFurther = 2, kNear = 1e-3;  // what a shape may cost: so many times as far off, and of the size

// Of unit normals. On flat parts, where other collapses cost nothing, short edges become the cheapest. From 3e-5 to
// 3e-4 a thin tray's smallest dihedral angle is 2.8 to 4 degrees, 0.005 without, and it is 0.12 to 0.3 % off, 0.02
// without.
constexpr double kNormalDeviation = 1e-4;
constexpr double kWeight = 100;         // of what keeps borders in place (CGAL's own default)
constexpr double kFinerEdges = 2. / 3;  // than the wanted number of triangles will have, before they are spread evenly
constexpr int kMostNodes = 500000;

/// Smallest altitude by longest edge [-]: 0.87 of an equilateral triangle, 0 of one without area.
double shape_of(const Point& a, const Point& b, const Point& c) {
  const double longest =
      std::max({CGAL::squared_distance(a, b), CGAL::squared_distance(b, c), CGAL::squared_distance(c, a)});
  return longest > 0 ? std::sqrt(CGAL::cross_product(b - a, c - a).squared_length()) / longest : 0;
}

/// Refuses a place that turns a triangle over, or leaves one flatter than `least` and than all were before. On flat
/// parts every collapse costs nothing, and without this what is left are slivers that simulation has to pay for.
struct ShapeFilter {
  double least = 0;

  /// @param place  optional: of Boost's before CGAL 6, of the standard library's since
  template <class Profile, class Place>
  Place operator()(const Profile& profile, Place place) const {
    place = sms::Bounded_normal_change_filter<>()(profile, place);
    if (!place) return place;
    const auto before = [&](Surface::Vertex_index v) { return profile.surface_mesh().point(v); };
    const auto moves = [&](Surface::Vertex_index v) { return v == profile.v0() || v == profile.v1(); };
    const auto after = [&](Surface::Vertex_index v) { return moves(v) ? *place : before(v); };
    double least_before = 1, least_after = 1;
    for (const auto& t : profile.triangles()) {
      least_before = std::min(least_before, shape_of(before(t.v0), before(t.v1), before(t.v2)));
      if (moves(t.v0) + moves(t.v1) + moves(t.v2) < 2)  // else it vanishes with the edge
        least_after = std::min(least_after, shape_of(after(t.v0), after(t.v1), after(t.v2)));
    }
    if (least_after < std::min(least, least_before)) return {};
    return place;
  }
};

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

constexpr double kAnyCost = std::numeric_limits<double>::infinity();

/// Stops at a number of edges, or where a collapse costs too much; remembers the dearest one.
struct Stop {
  std::size_t edges;
  double limit;
  double& dearest;

  template <class Profile>
  bool operator()(double cost, const Profile&, std::size_t, std::size_t edges_now) const {
    if (edges_now <= edges || cost > limit) return true;
    dearest = std::max(dearest, cost);
    return false;
  }
};

/// @return the cost of its dearest collapse
template <class Quadric>
double collapse(Surface& mesh, const Quadric& quadrics, std::size_t edges, double least_shape, double limit) {
  double dearest = 0;
  sms::edge_collapse(mesh, Stop{edges, limit, dearest},
                     CGAL::parameters::get_cost(quadrics).get_placement(quadrics).filter(ShapeFilter{least_shape}));
  mesh.collect_garbage();
  return dearest;
}

double collapse(Surface& mesh, bool evenly, std::size_t edges, double least_shape, double limit) {
  return evenly
             ? collapse(mesh, EvenQuadrics(mesh, kWeight, Variances({kNormalDeviation, 0})), edges, least_shape, limit)
             : collapse(mesh, Quadrics(mesh), edges, least_shape, limit);
}

/// Edges of so many regular triangles over the same area.
double even_edge(const Mesh& surface, int triangles) {
  double area = 0;
  for (const Triangle& t : surface.triangles)
    area += 0.5 *
            (node(surface.x, t[1]) - node(surface.x, t[0])).cross(node(surface.x, t[2]) - node(surface.x, t[0])).norm();
  return std::sqrt(4 * area / (std::sqrt(3.0) * triangles));
}

}  // namespace

Mesh decimate_cgal(const Mesh& surface, int triangles, bool evenly) {
  Surface mesh = to_cgal(
      evenly ? refine_surface(surface, {.edge = kFinerEdges * even_edge(surface, triangles), .growth = 0}, kMostNodes)
             : surface);
  // Edges are what the stop counts: three for two triangles of a closed surface.
  const std::size_t edges = static_cast<std::size_t>(triangles) * 3 / 2;
  // What is crumpled or thin would be eaten away by collapses that only a good shape asks for.
  Surface any_shape = mesh;
  const double cost = collapse(any_shape, evenly, edges, 0, kAnyCost);  // a squared distance
  const double size = surface.x.maxCoeff() - surface.x.minCoeff();
  const double limit = std::pow(kFurther * std::sqrt(cost) + kNear * size, 2);
  for (const double least : kLeastShapes)
    if (mesh.number_of_edges() > edges) collapse(mesh, evenly, edges, least, least > 0 ? limit : kAnyCost);
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
