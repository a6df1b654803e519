#include "core/contact_surface/rest_surface.hpp"

#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <vector>

#include "core/contact_surface/contact_surface.hpp"
#include "core/contact_surface/subdivision.hpp"

namespace kt {
namespace {

constexpr int kDegree = 4, kLevels = 2;  // two levels have the places at quarters

/// Of the place (i, j, 4 - i - j) / 4.
std::size_t place_of(int i, int j) { return static_cast<std::size_t>(i * (2 * kDegree + 3 - i) / 2 + j); }

/// Lagrange's polynomials over the quarters of an edge: t (t - 1) ... (t - m + 1) / m! at t = 4 w.
std::array<double, kDegree + 1> factors(double w) {
  std::array<double, kDegree + 1> out{1};
  for (std::size_t m = 1; m < out.size(); ++m)
    out[m] = out[m - 1] * (kDegree * w - static_cast<double>(m) + 1) / static_cast<double>(m);
  return out;
}

std::array<bool, 3> sharp_edges(const Surface& surface, std::size_t triangle) {
  if (surface.crease.empty()) return {};
  const auto& crease = surface.crease[triangle];
  return {crease[0] != Crease::none, crease[1] != Crease::none, crease[2] != Crease::none};
}

Vec3 weighted_sum(const Subdivision& of, int vertex, const VectorX& x) {
  Vec3 out = Vec3::Zero();
  for (int k = of.first[vertex]; k < of.first[vertex + 1]; ++k) out += of.weight[k] * node(x, of.from[k]);
  return out;
}

/// Points whose limit passes by x: twice moved out by what it misses, which leaves (1 - S)^3 x, S the limit of nodes.
VectorX control_points(const Surface& surface, const VectorX& x) {
  constexpr int kCorrections = 2;
  std::vector<std::array<bool, 3>> sharp;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) sharp.push_back(sharp_edges(surface, t));
  const auto nodes = static_cast<int>(surface.topology.first.size()) - 1;
  const Subdivision limit = subdivide_loop(surface.triangles, nodes, sharp, 0);
  VectorX out = x;
  for (int i = 0; i < kCorrections; ++i) {
    const VectorX before = out;
    for (int v = 0; v < nodes; ++v) node(out, v) += node(x, v) - weighted_sum(limit, v, before);
  }
  return out;
}

}  // namespace

RestSurface::RestSurface(const Surface& surface, const VectorX& x)
    : surface_(surface), x_(x), control_(control_points(surface, x)) {}

/// From the triangle and those around its corners.
const RestSurface::Quartic& RestSurface::over(int triangle) {
  if (const auto found = known_.find(triangle); found != known_.end()) return found->second;
  if (known_.size() >= kMost) known_.clear();
  std::set<int> ring;
  for (const int v : surface_.triangles[static_cast<std::size_t>(triangle)])
    for (const int t : surface_.topology.triangles_of(v)) ring.insert(t);
  std::vector<Triangle> triangles;
  std::vector<std::array<bool, 3>> sharp;
  std::map<int, int> number;  // of nodes, in the ring
  VectorX at;
  for (const int t : ring) {
    Triangle& own = triangles.emplace_back(surface_.triangles[static_cast<std::size_t>(t)]);
    sharp.push_back(sharp_edges(surface_, static_cast<std::size_t>(t)));
    for (int& v : own) {
      const auto [found, is_new] = number.try_emplace(v, static_cast<int>(number.size()));
      if (is_new) at.conservativeResize(at.size() + 3), at.tail<3>() = node(control_, v);
      v = found->second;
    }
  }
  const Subdivision smooth = subdivide_loop(triangles, static_cast<int>(number.size()), sharp, kLevels);
  constexpr int kPieces = 1 << (2 * kLevels);
  const auto first = kPieces * std::distance(ring.begin(), ring.find(triangle));
  Quartic& out = known_[triangle];
  for (int piece = 0; piece < kPieces; ++piece)
    for (int c = 0; c < 3; ++c) {
      const Vec3 w = kDegree * weights_in_triangle(piece, kLevels, Vec3::Unit(c));
      const int v = smooth.triangles[static_cast<std::size_t>(first + piece)][static_cast<std::size_t>(c)];
      out[place_of(static_cast<int>(std::lround(w[0])), static_cast<int>(std::lround(w[1])))] =
          weighted_sum(smooth, v, at);
    }
  return out;
}

Vec3 RestSurface::offset(int triangle, const Vec3& bary) {
  const Quartic& values = over(triangle);
  const auto a = factors(bary[0]), b = factors(bary[1]), c = factors(bary[2]);
  Vec3 out = Vec3::Zero();
  for (int i = 0; i <= kDegree; ++i)
    for (int j = 0; i + j <= kDegree; ++j)
      out += a[static_cast<std::size_t>(i)] * b[static_cast<std::size_t>(j)] *
             c[static_cast<std::size_t>(kDegree - i - j)] * values[place_of(i, j)];
  const Triangle& t = surface_.triangles[static_cast<std::size_t>(triangle)];
  for (int k = 0; k < 3; ++k) out -= bary[k] * node(x_, t[static_cast<std::size_t>(k)]);
  return out;
}

void RestSurface::raise(FinePatch& fine) {
  const auto vertices = static_cast<std::size_t>(fine.num_vertices());
  std::vector<std::set<int>> triangles(vertices);  // around each vertex
  std::vector<Vec3> own(vertices, Vec3::Zero());
  for (std::size_t f = 0; f < fine.facets.size(); ++f)
    for (std::size_t c = 0; c < 3; ++c) {
      const auto v = static_cast<std::size_t>(fine.facets[f][c]);
      if (triangles[v].empty()) own[v] = offset(fine.triangle[f], fine.corners[f].col(static_cast<Eigen::Index>(c)));
      triangles[v].insert(fine.triangle[f]);
    }
  fine.offsets.clear();
  for (std::size_t v = 0; v < vertices; ++v)
    for (const int i : triangles[v]) {
      const Triangle& t = surface_.triangles[static_cast<std::size_t>(i)];
      const Mat3 frame = triangle_frame(node(x_, t[0]), node(x_, t[1]), node(x_, t[2]));
      fine.offsets.push_back(
          {static_cast<int>(v), i, frame.transpose() * own[v] / static_cast<double>(triangles[v].size())});
    }
}

}  // namespace kt
