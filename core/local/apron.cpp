#include "core/local/apron.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace kt {
namespace {

/// The triangles outside the patch by their distance from the nearest site, at most `most`; ascending.
std::vector<int> nearest_outside(const Surface& surface, const VectorX& x, const ContactSite& site,
                                 const SurfacePatch& patch, int most) {
  std::vector<char> in_patch(surface.triangles.size(), 0);
  for (const int t : patch.global_triangle) in_patch[t] = 1;
  std::vector<std::pair<double, int>> by_distance;
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    if (in_patch[t]) continue;
    double nearest_sq = std::numeric_limits<double>::infinity();
    const auto consider = [&](const ContactSite& at) {
      const double way_sq = at.way.squaredNorm();
      for (const int i : surface.triangles[t]) {
        const Vec3 away = node(x, i) - at.centre;
        const double share = way_sq > 0 ? std::clamp(away.dot(at.way) / way_sq, 0.0, 1.0) : 0;
        nearest_sq = std::min(nearest_sq, (away - share * at.way).squaredNorm());
      }
    };
    consider(site);
    for (const ContactSite& other : site.others) consider(other);
    by_distance.emplace_back(nearest_sq, t);
  }
  if (by_distance.size() > static_cast<std::size_t>(most)) {
    std::ranges::nth_element(by_distance, by_distance.begin() + most);
    by_distance.resize(static_cast<std::size_t>(most));
  }
  std::vector<int> out;
  for (const auto& [distance_sq, t] : by_distance) out.push_back(t);
  std::ranges::sort(out);
  return out;
}

/// Those that a tool in reach touches; of a patch that has none that can move, all that can.
std::vector<int> leading_vertices(const SurfacePatch& patch, const std::vector<char>& moves) {
  std::vector<int> in_reach, others;
  for (int v = 0; v < patch.num_vertices(); ++v)
    if (moves[v]) (patch.in_reach[v] ? in_reach : others).push_back(v);
  return in_reach.empty() ? others : in_reach;
}

/// The one or two of these vertices that are nearest to a place, with weights as the distances suggest.
std::vector<std::pair<int, double>> nearest_two(const std::vector<int>& vertices, const VectorX& x,
                                                const SurfacePatch& patch, const Vec3& place) {
  constexpr double kLeast = 1e-300;
  double first_sq = std::numeric_limits<double>::infinity(), second_sq = first_sq;
  int first = -1, second = -1;
  for (const int v : vertices) {
    const double distance_sq = std::max((node(x, patch.global_node[v]) - place).squaredNorm(), kLeast);
    if (distance_sq < first_sq) {
      second_sq = std::exchange(first_sq, distance_sq);
      second = std::exchange(first, v);
    } else if (distance_sq < second_sq) {
      second_sq = distance_sq;
      second = v;
    }
  }
  if (first < 0) return {};
  if (second < 0) return {{first, 1.0}};
  const double share = second_sq / (first_sq + second_sq);
  return {{first, share}, {second, 1 - share}};
}

}  // namespace

Apron make_apron(const Surface& surface, const VectorX& x, const ContactSite& site, const SurfacePatch& patch,
                 const std::vector<char>& moves, const std::vector<char>& is_fixed, int most) {
  Apron out;
  out.global_triangle = nearest_outside(surface, x, site, patch, most);
  std::map<int, int> vertex_of;
  for (int v = 0; v < patch.num_vertices(); ++v) vertex_of.emplace(patch.global_node[v], v);
  for (const int t : out.global_triangle) {
    Triangle& local = out.triangles.emplace_back();
    for (int c = 0; c < 3; ++c) {
      const int next = patch.num_vertices() + static_cast<int>(out.global_node.size());
      const auto [found, is_new] = vertex_of.emplace(surface.triangles[t][c], next);
      if (is_new) out.global_node.push_back(found->first);
      local[c] = found->second;
    }
  }
  const std::vector<int> leading = leading_vertices(patch, moves);
  out.x.resize(3 * static_cast<Eigen::Index>(out.global_node.size()));
  out.first.push_back(0);
  for (std::size_t i = 0; i < out.global_node.size(); ++i) {
    const Vec3 place = node(x, out.global_node[i]);
    node(out.x, static_cast<int>(i)) = place;
    if (!is_fixed[out.global_node[i]]) {
      for (const auto& [v, weight] : nearest_two(leading, x, patch, place)) {
        out.from.push_back(v);
        out.weight.push_back(weight);
      }
    }
    out.first.push_back(static_cast<int>(out.from.size()));
  }
  return out;
}

void add_apron(const Apron& apron, const Surface& surface, const SurfacePatch& patch, const VectorX& patch_x,
               ContactSurface& out) {
  SurfacePatch& facets = out.facets;
  out.apron_facets = static_cast<int>(facets.triangles.size());
  out.apron_vertices = facets.num_vertices();
  std::vector<Vec3> offset;
  const auto add_vertex = [&](int global, const Vec3& place, auto followed, auto weight) {
    Vec3 rest = place;
    for (std::size_t k = 0; k < followed.size(); ++k) {
      out.from.push_back(followed[k]);
      out.weight.push_back(weight[k]);
      rest -= weight[k] * node(patch_x, followed[k]);
    }
    out.first.push_back(static_cast<int>(out.from.size()));
    facets.global_node.push_back(global);
    offset.push_back(rest);
    return facets.num_vertices() - 1;
  };
  const auto own = [&](int i) {
    const auto begin = static_cast<std::size_t>(apron.first[i]);
    const auto count = static_cast<std::size_t>(apron.first[i + 1]) - begin;
    return std::pair(std::span(apron.from).subspan(begin, count), std::span(apron.weight).subspan(begin, count));
  };
  // A smooth patch has other vertices than its nodes: the apron's triangles get those for themselves.
  const int shared = out.levels == 0 ? patch.num_vertices() : 0;
  std::map<int, int> vertex_of;
  const auto vertex = [&](int v) {
    if (v < shared) return v;
    const auto known = vertex_of.find(v);
    if (known != vertex_of.end()) return known->second;
    int added;
    if (v < patch.num_vertices()) {
      added = add_vertex(patch.global_node[v], node(patch_x, v), std::array{v}, std::array{1.0});
    } else {
      const int i = v - patch.num_vertices();
      const auto [followed, weight] = own(i);
      added = add_vertex(apron.global_node[i], node(apron.x, i), followed, weight);
    }
    vertex_of.emplace(v, added);
    return added;
  };
  for (std::size_t t = 0; t < apron.triangles.size(); ++t) {
    const Triangle& v = apron.triangles[t];
    const Triangle facet{vertex(v[0]), vertex(v[1]), vertex(v[2])};
    facets.triangles.push_back(facet);
    facets.global_triangle.push_back(apron.global_triangle[t]);
    facets.on_rim.push_back(1);
    if (!facets.wall.empty())
      facets.wall.push_back(out.levels == 0 ? surface.wall[apron.global_triangle[t]] : std::array{0, 0, 0});
    if (!facets.crease.empty()) facets.crease.push_back(surface.crease[apron.global_triangle[t]]);
    std::map<int, Vec3> moved;
    for (int c = 0; c < 3; ++c)
      for (int k = out.first[facet[c]]; k < out.first[facet[c] + 1]; ++k)
        moved.try_emplace(out.from[k], Vec3::Zero()).first->second[c] += out.weight[k];
    for (const auto& [patch_vertex, weight] : moved) {
      out.moved_node.push_back(patch_vertex);
      out.moved_weight.push_back(weight);
    }
    out.first_moved.push_back(static_cast<int>(out.moved_node.size()));
  }
  facets.in_reach.resize(facets.global_node.size(), 0);
  facets.topology = make_topology(facets.triangles, facets.num_vertices());
  out.apron_offset.resize(3 * static_cast<Eigen::Index>(offset.size()));
  for (std::size_t i = 0; i < offset.size(); ++i) node(out.apron_offset, static_cast<int>(i)) = offset[i];
}

}  // namespace kt
