#include "core/fine/fine_surface.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace kt {
namespace {

/// Cosine between normals. A scan's may be rough, and those of triangles that are there twice, once turned, cancel.
constexpr double kSameSide = -0.5;
constexpr double kLeastApart = 1e-3;  // of the extent: where vertices of a scan that is taken as it is are too many

/// Where vertices are, and which way the surface looks there.
struct Sides {
  Sides(const VectorX& x, const EmbeddedFacets& e)
      : normal(e.vertex.size(), Vec3::Zero()), has_facet(e.vertex.size(), 0) {
    for (const CellPoint& p : e.vertex) place.push_back(p.of(x));
    for (const Triangle& t : e.facets) {
      const Vec3 n = (place[t[1]] - place[t[0]]).cross(place[t[2]] - place[t[0]]);
      for (const int v : t) {
        normal[v] += n;  // weighted by area
        has_facet[v] = 1;
      }
    }
    for (Vec3& n : normal) n.normalize();
  }
  /// Others are of triangles that were left out.
  std::vector<int> with_facets() const {
    std::vector<int> out;
    for (int v = 0; v < static_cast<int>(has_facet.size()); ++v)
      if (has_facet[v]) out.push_back(v);
    return out;
  }
  /// Of the box around them, its diagonal [m].
  double extent() const {
    Vec3 low = place.front(), high = low;
    for (const Vec3& p : place) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    return (high - low).norm();
  }
  bool are_alike(int a, int b) const { return normal[a].dot(normal[b]) > kSameSide; }

  std::vector<Vec3> place, normal;
  std::vector<char> has_facet;
};

/// Vertices in boxes as large as they are looked for around one.
class NearVertices {
 public:
  NearVertices(const Sides& sides, double reach) : sides_(sides), reach_(reach) {}
  void add(int v) { in_[box_of(sides_.place[v])].push_back(v); }

  /// Gives those on the side of v that are nearer than the reach, until it says true.
  template <class Give>
  bool any(int v, const Give& give) const {
    const Box box = box_of(sides_.place[v]);
    for (long i = -1; i <= 1; ++i)
      for (long j = -1; j <= 1; ++j)
        for (long k = -1; k <= 1; ++k) {
          const auto found = in_.find({box[0] + i, box[1] + j, box[2] + k});
          if (found == in_.end()) continue;
          for (const int other : found->second)
            if ((sides_.place[other] - sides_.place[v]).squaredNorm() < reach_ * reach_ && sides_.are_alike(other, v) &&
                give(other))
              return true;
        }
    return false;
  }

 private:
  using Box = std::array<long, 3>;
  Box box_of(const Vec3& p) const {
    return {std::lround(p[0] / reach_), std::lround(p[1] / reach_), std::lround(p[2] / reach_)};
  }
  const Sides& sides_;
  double reach_;
  std::map<Box, std::vector<int>> in_;
};

/// Vertices with facets, in the order in which they are taken: by their numbers alone, so that most stay from zone to
/// zone, and the scan's own before those that pieces of its triangles have.
std::vector<int> order_of(const Sides& sides, const std::vector<CellPoint>& vertex) {
  std::vector<std::tuple<bool, std::uint32_t, int>> keyed;
  for (const int v : sides.with_facets())
    keyed.emplace_back(vertex[v].count > 1, mixed(static_cast<int>(CellPointHash()(vertex[v]))), v);
  std::ranges::sort(keyed);
  std::vector<int> out;
  for (const auto& [is_of_piece, number, v] : keyed) out.push_back(v);
  return out;
}

/// Adds vertices to a set, that are no nearer than `apart` to one of it on the same side of the surface, until it has
/// `most` or no other one can be added. (A maximal independent set by fixed priorities: Luby 1986.)
/// @return  whether it has room for all that can be added
bool add_places(const Sides& sides, const std::vector<int>& order, double apart, std::size_t most,
                std::vector<int>& places) {
  NearVertices kept(sides, apart);
  for (const int v : places) kept.add(v);
  for (const int v : order) {
    if (kept.any(v, [](int) { return true; })) continue;
    if (places.size() == most) return false;
    kept.add(v);
    places.push_back(v);
  }
  return true;
}

/// At most `most`. First as far apart as they have to be, then those between these that there is room for: a set with
/// larger distances alone can be a third of what there is room for, and a tool lies between its places.
/// @param apart  in: how far at least; out: none of the others is further from a place
/// @return  ascending
std::vector<int> find_places(const Sides& sides, const std::vector<CellPoint>& vertex, std::size_t most,
                             double& apart) {
  constexpr double kWider = 1.25;
  const std::vector<int> order = order_of(sides, vertex);
  const double extent = sides.extent();
  std::vector<int> out;
  if (!(apart > 0)) {
    if (order.size() <= most) return sides.with_facets();
    apart = kLeastApart * extent;
  }
  const double least = apart;
  bool fits = true;  // there may be more sides than nodes
  while (!add_places(sides, order, apart, fits ? most : order.size(), out)) {
    out.clear();
    fits = apart < extent;
    if (fits) apart *= kWider;
  }
  for (double less = std::max(apart / kWider, least); fits && less < apart; less = std::max(apart / kWider, least)) {
    if (!add_places(sides, order, less, most, out)) break;
    apart = less;
  }
  std::ranges::sort(out);
  return out;
}

constexpr std::size_t kMostNear = 6;
using Shares = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostNear, 1>;

/// Of a point among others: they sum to 1, and give the point's own place as nearly as they can without being large for
/// those that are far: least sum of (w r / unit)^2 + kLinear (sum of w (x - own) / unit)^2, those below zero left out.
Shares shares_among(const Vec3& own, std::span<const Vec3> others, double unit) {
  constexpr double kLinear = 10, kRound = 0.01;
  const auto n = static_cast<Eigen::Index>(others.size());
  Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, kMostNear> apart(3, n);
  for (Eigen::Index i = 0; i < n; ++i) apart.col(i) = (others[static_cast<std::size_t>(i)] - own) / unit;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostNear, kMostNear> A =
      kLinear * apart.transpose() * apart;
  for (Eigen::Index i = 0; i < n; ++i) A(i, i) += apart.col(i).squaredNorm() + kRound;
  const Shares out = A.ldlt().solve(Shares::Ones(n)).cwiseMax(0);
  return out / out.sum();
}

void spread(const Sides& sides, EmbeddedFacets& e) {
  constexpr double kReach = 2;  // of how far places are apart
  NearVertices places(sides, kReach * e.apart);
  std::vector<int> number(e.vertex.size(), -1);
  for (std::size_t i = 0; i < e.places.size(); ++i) {
    number[e.places[i]] = static_cast<int>(i);
    if (e.apart > 0) places.add(e.places[i]);
  }
  e.first_near.assign(1, 0);
  for (int v = 0; v < static_cast<int>(e.vertex.size()); ++v) {
    if (number[v] >= 0) {
      e.near.push_back(number[v]);
      e.share.push_back(1);
    } else if (sides.has_facet[v]) {
      std::vector<std::pair<double, int>> near;
      places.any(v, [&](int other) {
        near.emplace_back((sides.place[other] - sides.place[v]).squaredNorm(), other);
        return false;
      });
      std::ranges::sort(near);
      near.resize(std::min(near.size(), kMostNear));
      std::vector<Vec3> at;
      for (const auto& [distance_sq, other] : near) at.push_back(sides.place[other]);
      const Shares shares = shares_among(sides.place[v], at, e.apart);
      for (std::size_t i = 0; i < near.size(); ++i) {
        e.near.push_back(number[near[i].second]);
        e.share.push_back(shares[static_cast<Eigen::Index>(i)]);
      }
    }
    e.first_near.push_back(static_cast<int>(e.near.size()));
  }
}

}  // namespace

void choose_places(const VectorX& x, FineZone& zone) {
  EmbeddedFacets& e = zone.embedded;
  const Sides sides(x, e);
  e.is_place.assign(e.vertex.size(), 0);
  e.first_near.assign(e.vertex.size() + 1, 0);
  if (zone.num_yielding == 0 || e.facets.empty()) return;
  e.places = find_places(sides, e.vertex, static_cast<std::size_t>(zone.num_yielding), e.apart);
  for (const int v : e.places) e.is_place[v] = 1;
  spread(sides, e);
}

}  // namespace kt
