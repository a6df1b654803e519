#include "io/surface/mesh_doctor.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "core/base/error.hpp"
#include "io/mesh/edge_table.hpp"
#include "io/surface/winding_number.hpp"

namespace kt {
namespace {

bool is_finite(const VectorX& x, const Triangle& t) {
  return std::all_of(t.begin(), t.end(), [&](int i) { return node(x, i).allFinite(); });
}

Vec3 centre_of(const VectorX& x, const Triangle& t) { return (node(x, t[0]) + node(x, t[1]) + node(x, t[2])) / 3.0; }

MeshPlace at_triangle(const Mesh& mesh, int t) {
  return {centre_of(mesh.x, mesh.triangles[t]), {mesh.triangles[t].begin(), mesh.triangles[t].end()}, {t}, {}};
}

MeshPlace at_edge(const Mesh& mesh, const EdgeTable& table, const Edge& e) {
  MeshPlace place{0.5 * (node(mesh.x, e.a) + node(mesh.x, e.b)), {e.a, e.b}, {}, {}};
  for (const EdgeUse& use : table.uses_of(e)) place.triangles.push_back(use.triangle);
  return place;
}

void examine_nodes(const Mesh& mesh, MeshReport& r) {
  std::vector<bool> used(static_cast<std::size_t>(mesh.num_nodes()), false);
  for (const Triangle& t : mesh.triangles)
    for (const int i : t) used[i] = true;
  for (const Tetrahedron& t : mesh.tetrahedra)
    for (const int i : t) used[i] = true;
  std::map<std::array<double, 3>, std::vector<int>> by_position;
  bool first = true;
  for (int i = 0; i < mesh.num_nodes(); ++i) {
    const Vec3 p = node(mesh.x, i);
    if (!used[i]) r.isolated_nodes.push_back({p, {i}, {}, {}});
    if (!p.allFinite()) {
      r.non_finite.push_back({p, {i}, {}, {}});
      continue;
    }
    if (used[i]) by_position[{p[0] + 0.0, p[1] + 0.0, p[2] + 0.0}].push_back(i);
    r.box.min = first ? p : r.box.min.cwiseMin(p).eval();
    r.box.max = first ? p : r.box.max.cwiseMax(p).eval();
    first = false;
  }
  for (const auto& [p, nodes] : by_position)
    if (nodes.size() > 1) r.coincident_nodes.push_back({Vec3(p[0], p[1], p[2]), nodes, {}, {}});
}

/// Triangles that count for the topology: the first of each set of duplicates, with three different nodes.
std::vector<Triangle> examine_triangles(const Mesh& mesh, MeshReport& r) {
  std::vector<Triangle> kept;
  std::map<Triangle, int> known;
  for (int t = 0; t < r.triangles; ++t) {
    const Triangle& corners = mesh.triangles[t];
    const bool finite = is_finite(mesh.x, corners);
    if (repeats_node(corners) || (finite && is_degenerate(mesh.x, corners)))
      r.degenerate.push_back(at_triangle(mesh, t));
    Triangle key = corners;
    std::sort(key.begin(), key.end());
    const auto [it, fresh] = known.try_emplace(key, t);
    if (!fresh && !repeats_node(corners)) {
      r.duplicates.push_back(at_triangle(mesh, t));
      r.duplicates.back().triangles.push_back(it->second);
    }
    // A duplicate stays in the list as an empty triangle, so that numbers keep their meaning.
    kept.push_back(fresh ? corners : Triangle{corners[0], corners[0], corners[0]});
    if (!finite) continue;
    const Vec3 a = node(mesh.x, corners[0]);
    r.area += 0.5 * (node(mesh.x, corners[1]) - a).cross(node(mesh.x, corners[2]) - a).norm();
  }
  return kept;
}

void examine_edges(const Mesh& mesh, const EdgeTable& table, MeshReport& r) {
  double sum = 0;
  int finite = 0;
  r.edges = static_cast<int>(table.edges.size());
  for (const Edge& e : table.edges) {
    if (e.count == 1) r.open_edges.push_back(at_edge(mesh, table, e));
    if (e.count > 2) r.nonmanifold_edges.push_back(at_edge(mesh, table, e));
    const double length = (node(mesh.x, e.a) - node(mesh.x, e.b)).norm();
    if (!std::isfinite(length)) continue;
    r.edge_min = finite == 0 ? length : std::min(r.edge_min, length);
    r.edge_max = std::max(r.edge_max, length);
    sum += length;
    ++finite;
  }
  if (finite > 0) r.edge_mean = sum / finite;
}

double volume_of(const VectorX& x, const std::vector<Triangle>& triangles) {
  double six = 0;
  const Vec3 origin = triangles.empty() ? Vec3::Zero().eval() : Vec3(node(x, triangles[0][0]));
  for (const Triangle& t : triangles)
    six += (node(x, t[0]) - origin).dot((node(x, t[1]) - origin).cross(node(x, t[2]) - origin));
  return six / 6;
}

/// Piece p lies inside closed piece q. Some corners of p are tried: pieces that cross are not inside each other.
bool is_inside(const VectorX& x, const std::vector<Triangle>& p, const Bounds& box_p, const std::vector<Triangle>& q,
               const Bounds& box_q) {
  if ((box_p.min.array() < box_q.min.array()).any() || (box_p.max.array() > box_q.max.array()).any()) return false;
  constexpr std::size_t kTried = 16;
  const std::size_t step = std::max<std::size_t>(1, p.size() / kTried);
  for (std::size_t i = 0; i < p.size(); i += step)
    if (std::lround(winding_number(x, q, node(x, p[i][0]))) % 2 == 0) return false;
  return true;
}

/// Orientation inside each piece, then of closed pieces against each other: a piece inside an odd number of others
/// bounds a cavity and points inward.
void examine_orientation(const Mesh& mesh, const std::vector<Triangle>& kept, const EdgeTable& table, MeshReport& r) {
  r.components = find_pieces(kept, table, true).count;
  const Pieces pieces = find_pieces(kept, table, false);  // three triangles on an edge say nothing about orientation
  std::vector<std::array<int, 2>> votes(static_cast<std::size_t>(pieces.count), {0, 0});
  std::vector<int> first(votes.size(), -1);
  for (int t = 0; t < r.triangles; ++t)
    if (const int p = pieces.piece[t]; p >= 0) {
      ++votes[p][pieces.reversed[t]];
      if (first[p] < 0) first[p] = t;
    }
  for (int t = 0; t < r.triangles; ++t)
    if (const int p = pieces.piece[t]; p >= 0 && !pieces.one_sided[p])
      if (votes[p][0] > 0 && votes[p][1] > 0 && pieces.reversed[t] != (votes[p][1] > votes[p][0]))
        r.flipped.push_back(at_triangle(mesh, t));
  for (int p = 0; p < pieces.count; ++p)
    if (pieces.one_sided[p]) r.one_sided.push_back(at_triangle(mesh, first[p]));

  if (!r.non_finite.empty() || !r.closed() || !r.flipped.empty() || !r.one_sided.empty()) return;
  std::vector<std::vector<Triangle>> of_piece(votes.size());
  std::vector<Bounds> box(votes.size());
  for (int t = 0; t < r.triangles; ++t) {
    const int p = pieces.piece[t];
    if (p < 0) continue;
    if (of_piece[p].empty()) box[p].min = box[p].max = node(mesh.x, kept[t][0]);
    of_piece[p].push_back(kept[t]);
    for (const int i : kept[t]) {
      box[p].min = box[p].min.cwiseMin(node(mesh.x, i));
      box[p].max = box[p].max.cwiseMax(node(mesh.x, i));
    }
  }
  for (int p = 0; p < pieces.count; ++p) {
    int around = 0;
    for (int q = 0; q < pieces.count; ++q)
      around += q != p && is_inside(mesh.x, of_piece[p], box[p], of_piece[q], box[q]);
    const double volume = volume_of(mesh.x, of_piece[p]);
    if (around % 2 == 0 && volume < 0) r.inside_out.push_back(at_triangle(mesh, first[p]));
    if (around % 2 == 1 && volume > 0) r.nested.push_back(at_triangle(mesh, first[p]));
  }
}

}  // namespace

double likely_scale(const Bounds& box) {
  const double size = box.size().maxCoeff();
  if (!(size > 0) || !std::isfinite(size)) return 0;
  double best = 1;
  for (const double unit : {1e-2, 1e-3, 1e-6})
    if (std::abs(std::log(size * unit / 0.15)) < std::abs(std::log(size * best / 0.15))) best = unit;
  return best;
}

std::string likely_unit(const Bounds& box) {
  const double scale = likely_scale(box);
  if (scale == 0) return "none: the mesh has no size";
  const char* name = scale == 1 ? "m" : scale == 1e-2 ? "cm" : scale == 1e-3 ? "mm" : "um";
  return text(name, " (the longest side would be ", box.size().maxCoeff() * scale, " m)");
}

bool MeshReport::clean() const {
  if (triangles == 0) return false;
  for (const DefectList& d : defects(*this))
    if (!d.places->empty()) return false;
  return true;
}

std::vector<DefectList> defects(const MeshReport& r) {
  return {{"non_finite", "NaN or infinite coordinates", &r.non_finite},
          {"isolated_nodes", "nodes that nothing uses", &r.isolated_nodes},
          {"coincident_nodes", "nodes at the same place", &r.coincident_nodes,
           r.tetrahedra > 0 ? "kilotouch mesh repair --weld TOL" : ""},
          {"degenerate", "triangles without area", &r.degenerate},
          {"duplicates", "triangles that occur twice", &r.duplicates},
          {"open_edges", "open edges", &r.open_edges},
          {"nonmanifold_edges", "edges of three or more triangles", &r.nonmanifold_edges},
          {"nonmanifold_nodes", "nodes where several fans touch", &r.nonmanifold_nodes},
          {"flipped", "triangles turned the wrong way", &r.flipped},
          {"one_sided", "pieces that cannot be oriented", &r.one_sided},
          {"inside_out", "closed pieces that are inside out", &r.inside_out},
          {"nested", "closed pieces inside another, both outward", &r.nested},
          {"self_intersections", "pairs of triangles that intersect", &r.self_intersections},
          {"flat_tetrahedra", "tetrahedra without volume", &r.flat_tetrahedra}};
}

std::string describe(const MeshPlace& place) {
  std::string out = text("at (", place.at[0], ", ", place.at[1], ", ", place.at[2], ")");
  const auto list = [&](const char* name, const std::vector<int>& numbers) {
    constexpr std::size_t kShown = 6;
    if (numbers.empty()) return;
    out += text(", ", name, numbers.size() > 1 ? "s" : "");
    for (std::size_t i = 0; i < std::min(kShown, numbers.size()); ++i) out += text(' ', numbers[i]);
    if (numbers.size() > kShown) out += " ...";
  };
  list("node", place.nodes);
  list("triangle", place.triangles);
  list("tetrahedron number", place.tetrahedra);
  return out;
}

MeshReport examine(const Mesh& mesh, const MeshExamination& how) {
  MeshReport r;
  r.nodes = mesh.num_nodes();
  r.triangles = static_cast<int>(mesh.triangles.size());
  r.tetrahedra = static_cast<int>(mesh.tetrahedra.size());
  examine_nodes(mesh, r);
  r.likely_unit = likely_unit(r.box);
  const std::vector<Triangle> kept = examine_triangles(mesh, r);
  const EdgeTable table = make_edge_table(kept);
  examine_edges(mesh, table, r);
  const Fans fans = find_fans(kept, table, r.nodes);
  int on_surface = 0;
  for (int i = 0; i < r.nodes; ++i) {
    on_surface += fans.count[i] > 0;
    if (fans.count[i] > 1) r.nonmanifold_nodes.push_back({node(mesh.x, i), {i}, {}, {}});
  }
  const auto faces = std::count_if(kept.begin(), kept.end(), [](const Triangle& t) { return !repeats_node(t); });
  r.euler = on_surface - r.edges + static_cast<int>(faces);
  examine_orientation(mesh, kept, table, r);
  if (r.closed() && r.manifold() && r.one_sided.empty()) r.genus = (2 * r.components - r.euler) / 2;
  r.volume = volume_of(mesh.x, kept);
  for (int i = 0; i < r.tetrahedra; ++i) {
    const double volume = tetrahedron_volume(mesh.x, mesh.tetrahedra[i]);
    r.tetrahedra_volume += volume;
    const Tetrahedron& t = mesh.tetrahedra[i];
    if (!(volume > 0)) r.flat_tetrahedra.push_back({node(mesh.x, t[0]), {t.begin(), t.end()}, {}, {i}});
  }
#if KT_WITH_CGAL
  if (how.self_intersections) {
    r.self_intersections_checked = true;
    for (const auto& [p, q] : find_self_intersections(mesh, how.max_intersections, r.self_intersections_complete))
      r.self_intersections.push_back(
          {0.5 * (centre_of(mesh.x, mesh.triangles[p]) + centre_of(mesh.x, mesh.triangles[q])), {}, {p, q}, {}});
  }
#else
  (void)how;
#endif
  return r;
}

}  // namespace kt
