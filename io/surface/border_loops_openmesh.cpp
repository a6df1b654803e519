#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wpedantic"
#endif
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

#include <set>

#include "io/mesh/edge_table.hpp"
#include "io/surface/border_loops.hpp"

namespace kt {
namespace {

struct DoubleTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using HalfEdgeMesh = OpenMesh::TriMesh_ArrayKernelT<DoubleTraits>;

/// OpenMesh prints a complaint for every face it refuses, so those are left out beforehand: a directed edge is used
/// once.
HalfEdgeMesh half_edges(const Mesh& mesh) {
  HalfEdgeMesh out;
  std::vector<HalfEdgeMesh::VertexHandle> vertex;
  for (int i = 0; i < mesh.num_nodes(); ++i)
    vertex.push_back(out.add_vertex({mesh.x[3 * i], mesh.x[3 * i + 1], mesh.x[3 * i + 2]}));
  std::set<std::array<int, 2>> taken;
  for (const Triangle& t : mesh.triangles) {
    if (repeats_node(t)) continue;
    bool free = true;
    for (int k = 0; k < 3; ++k) free = free && !taken.count({t[k], t[(k + 1) % 3]});
    if (!free) continue;
    if (!out.add_face(vertex[t[0]], vertex[t[1]], vertex[t[2]]).is_valid()) continue;
    for (int k = 0; k < 3; ++k) taken.insert({t[k], t[(k + 1) % 3]});
  }
  return out;
}

}  // namespace

std::vector<BorderLoop> find_border_loops(const Mesh& mesh) {
  ::omerr().disable();  // complex vertices are in the doctor's report already
  HalfEdgeMesh half = half_edges(mesh);
  ::omerr().enable();
  std::vector<bool> seen(half.n_halfedges(), false);
  std::vector<BorderLoop> loops;
  for (const auto start : half.halfedges()) {
    if (!half.is_boundary(start) || seen[start.idx()]) continue;
    BorderLoop& loop = loops.emplace_back();
    HalfEdgeMesh::HalfedgeHandle h = start;
    do {
      seen[h.idx()] = true;
      loop.nodes.push_back(half.from_vertex_handle(h).idx());
      loop.length += half.calc_edge_length(h);
      loop.centre += node(mesh.x, loop.nodes.back());
      h = half.next_halfedge_handle(h);
    } while (h != start && !seen[h.idx()]);
    loop.centre /= static_cast<double>(loop.nodes.size());
  }
  return loops;
}

}  // namespace kt
