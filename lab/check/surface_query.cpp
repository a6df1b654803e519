#include "lab/check/surface_query.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kt {
namespace {

using Long = Eigen::Matrix<long double, 3, 1>;

void consider(std::span<const Triangle> triangles, const VectorX& x, int t, const Vec3& p, NearestPlace& best) {
  const Triangle& v = triangles[static_cast<std::size_t>(t)];
  const ClosestPoint at = closest_point_on_triangle(p, node(x, v[0]), node(x, v[1]), node(x, v[2]));
  if (best.triangle < 0 || at.distance_sq < best.at.distance_sq) best = {t, at};
}

}  // namespace

NearestPlace nearest_place(std::span<const Triangle> triangles, const VectorX& x, std::span<const int> candidates,
                           const Vec3& p) {
  NearestPlace out;
  for (const int t : candidates) consider(triangles, x, t, p, out);
  return out;
}

NearestPlace nearest_place(std::span<const Triangle> triangles, const VectorX& x, const Vec3& p) {
  NearestPlace out;
  for (int t = 0; t < static_cast<int>(triangles.size()); ++t) consider(triangles, x, t, p, out);
  return out;
}

std::optional<SegmentCrossing> crossing_of(const Vec3& a, const Vec3& b, const Vec3 (&triangle)[3], double* margin) {
  const Long d = (b - a).cast<long double>(), v0 = triangle[0].cast<long double>();
  const Long e1 = triangle[1].cast<long double>() - v0, e2 = triangle[2].cast<long double>() - v0;
  const Long s = a.cast<long double>() - v0, n = e1.cross(e2);
  const long double along = n.dot(d);
  if (along == 0) return {};
  const long double share = -n.dot(s) / along;
  const Long c = s + share * d;  // the crossing, from the first corner
  const long double area_sq = n.squaredNorm();
  const long double w1 = c.cross(e2).dot(n) / area_sq, w2 = e1.cross(c).dot(n) / area_sq;
  const long double least = std::min({w1, w2, 1 - w1 - w2});
  if (margin) *margin = static_cast<double>(least);
  if (!(least >= 0) || !(share >= 0) || !(share <= 1)) return {};
  return SegmentCrossing{-1, static_cast<double>(share), along < 0};
}

SurfaceQuery::SurfaceQuery(std::span<const Triangle> triangles, const VectorX& x, const std::string& backend)
    : triangles_(triangles), x_(x), index_(make_triangle_index(backend)), scratch_(triangles.size()) {
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const Triangle& t : triangles)
    for (const int i : t) {
      low = low.cwiseMin(Vec3(node(x, i)));
      high = high.cwiseMax(Vec3(node(x, i)));
    }
  size_ = (high - low).norm();
  index_->build(triangles, x);
  index_->refit(x, x);
}

NearestPlace SurfaceQuery::nearest(const Vec3& p, double guess) const {
  // Boxes are padded outward, so what is within the margin is among the candidates; further ones may be missing.
  for (double margin = guess;; margin *= 3) {
    const int found = index_->candidates({p, p}, margin, scratch_);
    const NearestPlace out =
        nearest_place(triangles_, x_, std::span(scratch_).first(static_cast<std::size_t>(found)), p);
    if (out.triangle >= 0 && out.at.distance_sq <= margin * margin) return out;
    if (margin > 1e3 * size_ + 1e3 * guess) return nearest_place(triangles_, x_, p);
  }
}

bool SurfaceQuery::is_within(const Vec3& p, double distance) const {
  const int found = index_->candidates({p, p}, distance, scratch_);
  return std::any_of(scratch_.begin(), scratch_.begin() + found, [&](int t) {
    const Triangle& v = triangles_[static_cast<std::size_t>(t)];
    return closest_point_on_triangle(p, node(x_, v[0]), node(x_, v[1]), node(x_, v[2])).distance_sq <
           distance * distance;
  });
}

std::optional<SegmentCrossing> SurfaceQuery::crossing(const Vec3& a, const Vec3& b, double from) const {
  // In pieces: the box of a long segment holds most of a surface.
  constexpr int kPieces = 32;
  const auto place = [&](double share) { return Vec3(a + share * (b - a)); };
  for (int piece = 0; piece < kPieces; ++piece) {
    const double begin = static_cast<double>(piece) / kPieces, end = static_cast<double>(piece + 1) / kPieces;
    if (end < from) continue;
    // Shares are rounded, so a crossing where two pieces meet is found with either.
    const int found = index_->candidates({place(begin), place(end)}, 1e-9 * size_, scratch_);
    std::optional<SegmentCrossing> first;
    for (int k = 0; k < found; ++k) {
      const int t = scratch_[static_cast<std::size_t>(k)];
      const Triangle& v = triangles_[static_cast<std::size_t>(t)];
      const Vec3 corners[3] = {node(x_, v[0]), node(x_, v[1]), node(x_, v[2])};
      auto hit = crossing_of(a, b, corners, nullptr);
      if (!hit || hit->share <= from || (first && hit->share >= first->share)) continue;
      hit->triangle = t;
      first = hit;
    }
    if (first && first->share <= end) return first;
  }
  return {};
}

}  // namespace kt
