#include "core/fine/fine_surface.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace kt {
namespace {

/// Cosine between normals. A scan's may be rough, and those of triangles that are there twice, once turned, cancel.
constexpr double kSameSide = -0.5;

/// Unit normals of the vertices, weighted by area.
std::vector<Vec3> normals(const VectorX& x, const EmbeddedFacets& e) {
  std::vector<Vec3> out(e.vertex.size(), Vec3::Zero());
  for (const Triangle& t : e.facets) {
    const Vec3 a = e.vertex[t[0]].of(x), n = (e.vertex[t[1]].of(x) - a).cross(e.vertex[t[2]].of(x) - a);
    for (const int v : t) out[v] += n;
  }
  for (Vec3& n : out) n.normalize();
  return out;
}

}  // namespace

std::vector<char> places_apart(const VectorX& x, const EmbeddedFacets& facets, double apart) {
  const std::vector<CellPoint>& vertex = facets.vertex;
  const std::vector<Vec3> normal = normals(x, facets);
  std::vector<Vec3> place(vertex.size());
  std::ranges::transform(vertex, place.begin(), [&](const CellPoint& p) { return p.of(x); });
  const auto at = [&](int v) -> const Vec3& { return place[v]; };
  using Box = std::array<long, 3>;
  const auto box_of = [&](const Vec3& p) {
    return Box{std::lround(p[0] / apart), std::lround(p[1] / apart), std::lround(p[2] / apart)};
  };
  std::map<Box, std::vector<int>> kept;
  const auto is_near_one = [&](int v) {
    const Box box = box_of(at(v));
    for (long i = -1; i <= 1; ++i)
      for (long j = -1; j <= 1; ++j)
        for (long k = -1; k <= 1; ++k) {
          const auto found = kept.find({box[0] + i, box[1] + j, box[2] + k});
          if (found != kept.end() && std::ranges::any_of(found->second, [&](int other) {
                return (at(other) - at(v)).squaredNorm() < apart * apart && normal[other].dot(normal[v]) > kSameSide;
              }))
            return true;
        }
    return false;
  };
  std::vector<int> order(vertex.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](int v) {
    return std::tuple(vertex[v].count > 1, mixed(static_cast<int>(CellPointHash()(vertex[v]))), v);
  });
  std::vector<char> out(vertex.size(), 0);
  for (const int v : order) {
    if (is_near_one(v)) continue;
    out[v] = 1;
    kept[box_of(at(v))].push_back(v);
  }
  return out;
}

}  // namespace kt
