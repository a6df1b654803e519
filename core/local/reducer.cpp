#include "core/local/reducer.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <queue>
#include <utility>

#include "core/body/embedded_surface.hpp"
#include "core/body/near_triangles.hpp"
#include "core/body/node_weights.hpp"

namespace kt {

#define REDUCER(name, available, option, what) \
  LocalModel reduce_##name(const TangentModel&, SurfacePatch, const ContactSite&, const ReduceOptions&);
#include "core/local/reducers.def"

std::vector<BackendInfo> reducer_backends() {
  return {
#define REDUCER(name, available, option, what) {#name, what, available != 0, option},
#include "core/local/reducers.def"
  };
}

ReduceFn find_reducer(const std::string& name) {
#define REDUCER(known, available, option, what) \
  if (name == #known) return reduce_##known;
#include "core/local/reducers.def"
  require_backend("reducer", name, reducer_backends());
  return {};
}

namespace {

/// By the distance of a box from the centre, or a place on its way. Along a straight way its square is convex: by its
/// slope halves are cut off, and no place is nearer than the slope goes down to.
bool within_reach(const Vec3& low, const Vec3& high, const ContactSite& site) {
  constexpr int kCuts = 40;
  const auto away = [&](const Vec3& p) { return Vec3(p - p.cwiseMax(low).cwiseMin(high)); };
  const double reach_sq = site.reach * site.reach;
  if (away(site.centre).squaredNorm() <= reach_sq) return true;
  if (site.way.isZero(0)) return false;
  double begin = 0, end = 1;
  for (int i = 0; i < kCuts; ++i) {
    const double at = 0.5 * (begin + end);
    const Vec3 from = away(site.centre + at * site.way);
    const double distance_sq = from.squaredNorm(), slope = 2 * from.dot(site.way);
    if (distance_sq <= reach_sq) return true;
    if (distance_sq - std::abs(slope) * 0.5 * (end - begin) > reach_sq) return false;
    (slope > 0 ? end : begin) = at;
  }
  return false;
}

/// By the triangle's bounding box: never leaves out one within reach.
bool within_reach(const VectorX& x, const Triangle& t, const ContactSite& site) {
  const Vec3 a = node(x, t[0]), b = node(x, t[1]), c = node(x, t[2]);
  return within_reach(a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c), site);
}

/// Triangles of an embedded surface within reach, whether or not they are connected: of a scan they need not be.
/// Of most cells the corners alone are looked at.
std::vector<int> embedded_within_reach(const Surface& surface, const VectorX& x, const ContactSite& site) {
  const EmbeddedGroups& groups = surface.embedded->groups;
  std::vector<int> out;
  for (int g = 0; g < groups.count(); ++g) {
    const auto [low, high] = box_of_group(groups, g, x);
    if (!within_reach(low, high, site)) continue;
    for (int k = groups.first_triangle[g]; k < groups.first_triangle[g + 1]; ++k)
      if (within_reach(x, surface.triangles[groups.triangle[k]], site)) out.push_back(groups.triangle[k]);
  }
  return out;
}

/// In any order.
std::vector<int> reachable_triangles(const Surface& surface, const VectorX& x, const ContactSite& site) {
  std::vector<int> found{site.triangle};
  std::vector<char> seen(surface.triangles.size(), 0);
  seen[site.triangle] = 1;
  if (surface.embedded)
    for (const int t : embedded_within_reach(surface, x, site))
      if (!std::exchange(seen[t], 1)) found.push_back(t);
  const auto visit_fans = [&](int triangle, auto accept) {
    for (int v : surface.triangles[triangle])
      for (int t : surface.topology.triangles_of(v))
        if (!seen[t] && accept(t)) {
          seen[t] = 1;
          found.push_back(t);
        }
  };
  for (std::size_t i = 0; i < found.size(); ++i)
    visit_fans(found[i], [&](int t) { return within_reach(x, surface.triangles[t], site); });
  const std::size_t core = found.size();
  for (std::size_t i = 0; i < core; ++i) visit_fans(found[i], [](int) { return true; });
  return found;
}

/// What carries the patch's vertices in the place of these: nodes of cells.
void embed(const EmbeddedSurface& surface, SurfacePatch& patch) {
  auto of_vertices = std::make_shared<EmbeddedPatch>();
  of_vertices->global_vertex = std::move(patch.global_node);
  const std::vector<char> vertex_in_reach = std::move(patch.in_reach);
  std::map<int, int> local;  // of nodes
  const auto for_each_carrier = [&](int global, const auto& work) {
    const NodeWeights its = surface.carried_by(global - surface.first);
    for (std::size_t k = 0; k < static_cast<std::size_t>(its.count); ++k) work(its.node[k], its.weight[k]);
  };
  for (const int v : of_vertices->global_vertex) for_each_carrier(v, [&](int node, double) { local.emplace(node, 0); });
  patch.global_node.clear();
  for (auto& [global, index] : local) {
    index = patch.num_vertices();
    patch.global_node.push_back(global);
  }
  patch.in_reach.assign(patch.global_node.size(), 0);
  for (std::size_t v = 0; v < of_vertices->global_vertex.size(); ++v) {
    for_each_carrier(of_vertices->global_vertex[v], [&](int node, double weight) {
      const int at = local[node];
      of_vertices->from.push_back(at);
      of_vertices->weight.push_back(weight);
      patch.in_reach[static_cast<std::size_t>(at)] |= vertex_in_reach[v];
    });
    of_vertices->first.push_back(static_cast<int>(of_vertices->from.size()));
  }
  patch.embedded = std::move(of_vertices);
}

}  // namespace

SurfacePatch make_patch(const Surface& surface, const VectorX& x, const ContactSite& site, bool smooth) {
  std::vector<int> triangles = reachable_triangles(surface, x, site);
  for (const ContactSite& other : site.others) {
    const std::vector<int> more = reachable_triangles(surface, x, other);
    triangles.insert(triangles.end(), more.begin(), more.end());
  }
  std::ranges::sort(triangles);
  triangles.erase(std::ranges::unique(triangles).begin(), triangles.end());
  return patch_of(surface, std::move(triangles), smooth);
}

SurfacePatch patch_of(const Surface& surface, std::vector<int> triangles, bool smooth) {
  SurfacePatch patch;
  patch.global_triangle = std::move(triangles);
  for (int t : patch.global_triangle)
    patch.global_node.insert(patch.global_node.end(), surface.triangles[t].begin(), surface.triangles[t].end());
  std::ranges::sort(patch.global_node);
  patch.global_node.erase(std::ranges::unique(patch.global_node).begin(), patch.global_node.end());
  std::vector<int> local(surface.topology.first.size(), -1);
  for (int i = 0; i < patch.num_vertices(); ++i) local[patch.global_node[i]] = i;
  std::vector<char> inside(surface.triangles.size(), 0);
  for (int t : patch.global_triangle) inside[t] = 1;
  for (int t : patch.global_triangle) {
    const Triangle& g = surface.triangles[t];
    patch.triangles.push_back({local[g[0]], local[g[1]], local[g[2]]});
    bool rim = false;
    for (int v : g)
      for (int other : surface.topology.triangles_of(v)) rim |= !inside[other];
    patch.on_rim.push_back(rim);
    if (!surface.wall.empty()) patch.wall.push_back(surface.wall[t]);
    if (!surface.crease.empty()) patch.crease.push_back(surface.crease[t]);
  }
  patch.topology = make_topology(patch.triangles, patch.num_vertices());
  const bool all = smooth || std::ranges::count(patch.on_rim, 0) == 0;
  patch.in_reach.assign(patch.global_node.size(), all);
  for (std::size_t t = 0; t < patch.triangles.size(); ++t)
    for (int v : patch.triangles[t]) patch.in_reach[static_cast<std::size_t>(v)] |= !patch.on_rim[t];
  if (surface.embedded) embed(*surface.embedded, patch);
  return patch;
}

int count_patch_vertices(const Surface& surface, const VectorX& x, const ContactSite& site) {
  std::vector<char> seen(surface.topology.first.size(), 0);
  int count = 0;
  for (const int t : reachable_triangles(surface, x, site))
    for (const int i : surface.triangles[t]) count += !std::exchange(seen[i], 1);
  return count;
}

LocalModel restrict_to_nodes(const TangentModel& tangent, SurfacePatch patch, std::vector<int> dynamic_nodes) {
  const int n = static_cast<int>(tangent.f0.size() / 3);
  std::vector<char> left_out(n, 0);
  for (int i : tangent.fixed_nodes) left_out[i] = 1;
  std::sort(dynamic_nodes.begin(), dynamic_nodes.end());
  dynamic_nodes.erase(std::unique(dynamic_nodes.begin(), dynamic_nodes.end()), dynamic_nodes.end());
  std::erase_if(dynamic_nodes, [&](int i) { return left_out[i]; });
  const int r = 3 * static_cast<int>(dynamic_nodes.size());
  std::vector<int> dof_of(3 * n, -1);
  for (int k = 0; k < r; ++k) dof_of[3 * dynamic_nodes[k / 3] + k % 3] = k;

  LocalModel out;
  out.t = tangent.state.t;
  out.recovered_node = patch.global_node;
  std::vector<char> in_patch(n, 0);
  for (int i : patch.global_node) in_patch[i] = 1;
  for (int i : dynamic_nodes)
    if (!in_patch[i]) out.recovered_node.push_back(i);
  out.patch = std::move(patch);

  const auto restrict_matrix = [&](const SparseMatrix& all) {
    std::vector<Eigen::Triplet<double>> entries;
    for (int c = 0; c < r; ++c)
      for (SparseMatrix::InnerIterator it(all, 3 * dynamic_nodes[c / 3] + c % 3); it; ++it)
        if (dof_of[it.row()] >= 0) entries.emplace_back(dof_of[it.row()], c, it.value());
    SparseMatrix small(r, r);
    small.setFromTriplets(entries.begin(), entries.end());
    return small;
  };
  out.mass = restrict_matrix(tangent.mass);
  out.damping = -restrict_matrix(tangent.dfdv);
  out.stiffness = -restrict_matrix(tangent.dfdx);

  // The outside stands still at its linearization position, so it takes its damping force at v0 with it.
  const VectorX f_still = tangent.f0 - tangent.dfdv * tangent.state.v;
  out.f0.resize(r);
  out.q_rate0.resize(r);
  for (int k = 0; k < r; ++k) {
    out.f0[k] = f_still[3 * dynamic_nodes[k / 3] + k % 3];
    out.q_rate0[k] = tangent.state.v[3 * dynamic_nodes[k / 3] + k % 3];
  }
  const int recovered = static_cast<int>(out.recovered_node.size());
  out.x0.resize(3 * recovered);
  out.v0.resize(3 * recovered);
  std::vector<Eigen::Triplet<double>> rows;
  for (int i = 0; i < recovered; ++i) {
    const int g = out.recovered_node[i];
    node(out.x0, i) = node(tangent.state.x, g);
    const bool moves = dof_of[3 * g] >= 0;
    node(out.v0, i) = moves ? Vec3(node(tangent.state.v, g)) : Vec3(Vec3::Zero());
    for (int c = 0; moves && c < 3; ++c) rows.emplace_back(3 * i + c, dof_of[3 * g + c], 1.0);
  }
  out.basis.resize(3 * recovered, r);
  out.basis.setFromTriplets(rows.begin(), rows.end());
  out.lift = out.lift_rate = out.fit = out.fit_rate = out.basis.transpose();
  return out;
}

}  // namespace kt
