#include "core/fine/held_vertices.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <tuple>

namespace kt {
namespace {

constexpr double kApart = 0.4;  // of a leaf's size: as dense as its nodes, half of it apart in squares

/// Without order over the surface.
std::uint32_t mixed(int number) {
  auto h = static_cast<std::uint32_t>(number) + 0x9e3779b9u;
  for (int i = 0; i < 2; ++i) h = (h ^ (h >> 16)) * 0x45d9f3bu;
  return h ^ (h >> 16);
}

/// Of each vertex: whether two of its triangles are at an angle of more than 30 degrees with their mean.
std::vector<char> find_sharp(const FineBody& body, const EmbeddedFacets& surface) {
  constexpr double kSharp = 0.866;  // cosine
  const VectorX& x = body.mesh->x;
  std::vector<Vec3> normals(surface.facets.size()), mean(surface.vertex.size(), Vec3::Zero());
  for (std::size_t f = 0; f < surface.facets.size(); ++f) {
    std::array<Vec3, 3> p;
    for (std::size_t c = 0; c < 3; ++c) p[c] = node(x, surface.vertex[static_cast<std::size_t>(surface.facets[f][c])]);
    normals[f] = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
    for (const int v : surface.facets[f]) mean[static_cast<std::size_t>(v)] += normals[f];
  }
  std::vector<char> out(surface.vertex.size(), 0);
  for (std::size_t f = 0; f < surface.facets.size(); ++f)
    for (const int v : surface.facets[f])
      if (normals[f].dot(mean[static_cast<std::size_t>(v)].normalized()) < kSharp) out[static_cast<std::size_t>(v)] = 1;
  return out;
}

}  // namespace

std::vector<double> distance_to_held(const FineBody& body, const EmbeddedFacets& surface) {
  const VectorX& x = body.mesh->x;
  const std::vector<char> is_sharp = find_sharp(body, surface);
  std::vector<int> order(surface.vertex.size()), held;
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](int v) {
    const int global = surface.vertex[static_cast<std::size_t>(v)];
    return std::tuple(!is_sharp[static_cast<std::size_t>(v)], mixed(global), global);
  });
  std::vector<double> out(surface.vertex.size(), 0);
  for (const int v : order) {
    const Vec3 at = node(x, surface.vertex[static_cast<std::size_t>(v)]);
    const double size = surface.leaf_size[static_cast<std::size_t>(v)];
    double nearest_sq = std::numeric_limits<double>::infinity();
    bool is_near = false;
    for (const int other : held) {
      const double apart = kApart * std::min(size, surface.leaf_size[static_cast<std::size_t>(other)]);
      const double distance_sq = (node(x, surface.vertex[static_cast<std::size_t>(other)]) - at).squaredNorm();
      nearest_sq = std::min(nearest_sq, distance_sq);
      is_near = is_near || distance_sq < apart * apart;
    }
    if (is_near)
      out[static_cast<std::size_t>(v)] = std::sqrt(nearest_sq);
    else
      held.push_back(v);
  }
  return out;
}

}  // namespace kt
