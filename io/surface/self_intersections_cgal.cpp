// Self-intersections of a triangle soup with CGAL's exact predicates. CGAL 5.5 tests only half-edge meshes, which a
// non-manifold mesh cannot become, so the pairs are decided here.
#include <CGAL/Box_intersection_d/Box_with_info_d.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>

#include <algorithm>
#include <map>

#include "io/mesh/edge_table.hpp"
#include "io/surface/mesh_doctor.hpp"

namespace kt {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, int>;

struct Soup {
  std::vector<Point> point;
  std::vector<Triangle> corners;
  Kernel::Triangle_3 triangle(int t) const {
    return {point[corners[t][0]], point[corners[t][1]], point[corners[t][2]]};
  }
};

/// Two triangles over one edge overlap when they are folded onto each other: coplanar, third corners on one side.
bool folded(const Soup& s, int a, int b, int p, int q) {
  return CGAL::coplanar(s.point[a], s.point[b], s.point[p], s.point[q]) &&
         CGAL::coplanar_orientation(s.point[a], s.point[b], s.point[p], s.point[q]) == CGAL::POSITIVE;
}

bool intersect(const Soup& s, int f, int g) {
  std::array<int, 3> shared{}, only_f{}, only_g{};
  int num_shared = 0, num_f = 0, num_g = 0;
  for (const int i : s.corners[f]) {
    const bool both = std::find(s.corners[g].begin(), s.corners[g].end(), i) != s.corners[g].end();
    both ? shared[num_shared++] = i : only_f[num_f++] = i;
  }
  for (const int i : s.corners[g])
    if (std::find(s.corners[f].begin(), s.corners[f].end(), i) == s.corners[f].end()) only_g[num_g++] = i;
  if (num_shared == 3) return false;  // a duplicate, which has its own place in the report
  if (num_shared == 2) return folded(s, shared[0], shared[1], only_f[0], only_g[0]);
  if (num_shared == 0) return CGAL::do_intersect(s.triangle(f), s.triangle(g));
  // They meet in one node; a further common point lies on the side opposite to it, of one or the other.
  return CGAL::do_intersect(s.triangle(g), Kernel::Segment_3(s.point[only_f[0]], s.point[only_f[1]])) ||
         CGAL::do_intersect(s.triangle(f), Kernel::Segment_3(s.point[only_g[0]], s.point[only_g[1]]));
}

}  // namespace

std::vector<std::array<int, 2>> find_self_intersections(const Mesh& mesh, std::size_t max_pairs, bool& complete) {
  Soup soup;
  // Nodes at equal positions count as one: triangles that meet there touch, they do not intersect.
  std::map<std::array<double, 3>, int> known;
  std::vector<int> joined(static_cast<std::size_t>(mesh.num_nodes()));
  for (int i = 0; i < mesh.num_nodes(); ++i) {
    const Vec3 p = node(mesh.x, i);
    soup.point.emplace_back(p[0], p[1], p[2]);
    joined[i] = p.allFinite() ? known.try_emplace({p[0] + 0.0, p[1] + 0.0, p[2] + 0.0}, i).first->second : -1;
  }
  std::vector<Box> boxes;
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
    Triangle c = mesh.triangles[t];
    for (int& i : c) i = joined[i];
    soup.corners.push_back(c);
    if (std::min({c[0], c[1], c[2]}) < 0 || repeats_node(c)) continue;
    if (CGAL::collinear(soup.point[c[0]], soup.point[c[1]], soup.point[c[2]])) continue;
    boxes.emplace_back(soup.triangle(t).bbox(), t);
  }
  std::vector<std::array<int, 2>> pairs;
  complete = true;
  struct Enough {};
  try {
    CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), [&](const Box& a, const Box& b) {
      if (!intersect(soup, a.info(), b.info())) return;
      if (pairs.size() == max_pairs) throw Enough{};
      pairs.push_back({std::min(a.info(), b.info()), std::max(a.info(), b.info())});
    });
  } catch (const Enough&) {
    complete = false;
  }
  std::sort(pairs.begin(), pairs.end());  // the library's order depends on its own random numbers
  return pairs;
}

}  // namespace kt
