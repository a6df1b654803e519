#include "haptics/setup/path_excitation.hpp"

#include <algorithm>
#include <cmath>

#include "collision/shape/closest_point.hpp"
#include "core/body/near_triangles.hpp"
#include "haptics/options/band_powers.hpp"

namespace kt {
namespace {

constexpr double kMostSpan = 20;  // [s] of a path that is looked at

ClosestPoint closest_on(const Surface& surface, const VectorX& x, int triangle, const Vec3& place) {
  const Triangle& t = surface.triangles[static_cast<std::size_t>(triangle)];
  return closest_point_on_triangle(place, node(x, t[0]), node(x, t[1]), node(x, t[2]));
}

Vec3 normal_of(const Surface& surface, const VectorX& x, int triangle) {
  const Triangle& t = surface.triangles[static_cast<std::size_t>(triangle)];
  return (node(x, t[1]) - node(x, t[0])).cross(node(x, t[2]) - node(x, t[0])).normalized();
}

}  // namespace

FollowedMotion::FollowedMotion(const Surface& surface, const VectorX& x, double radius, double mu)
    : surface_(surface), x_(x), radius_(radius), mu_(mu) {}

/// All triangles that can become the closest one while the tool is not far from here.
void FollowedMotion::look_around(const Vec3& place) {
  constexpr double kLeast = 2e-3;  // [m]
  double nearest_sq = std::numeric_limits<double>::infinity();
  for_each_near(surface_, x_, place, nearest_sq,
                [&](int t) { nearest_sq = std::min(nearest_sq, closest_on(surface_, x_, t, place).distance_sq); });
  const double nearest = std::sqrt(nearest_sq);
  looked_from_ = place;
  searched_ = std::max({kLeast, radius_, 0.5 * (nearest - radius_)});
  near_.clear();
  if (nearest > radius_ + searched_) return;  // it does not get there
  const double farthest = nearest + 2 * searched_;
  for_each_near(surface_, x_, place, (1 + 1e-9) * farthest * farthest, [&](int t) {
    if (std::sqrt(closest_on(surface_, x_, t, place).distance_sq) <= farthest) near_.push_back(t);
  });
  std::ranges::sort(near_);
}

Vec3 FollowedMotion::move_to(const Vec3& place) {
  const Vec3 step = has_last_ ? Vec3(place - last_) : Vec3::Zero();
  last_ = place;
  has_last_ = true;
  if (searched_ < 0 || (place - looked_from_).norm() > searched_) look_around(place);
  ClosestPoint nearest{.distance_sq = std::numeric_limits<double>::infinity()};
  int at = -1;
  for (const int t : near_)
    if (const ClosestPoint found = closest_on(surface_, x_, t, place); found.distance_sq < nearest.distance_sq) {
      nearest = found;
      at = t;
    }
  if (at < 0) {
    dragged_.setZero();
    return Vec3::Zero();
  }
  const Vec3 outward = normal_of(surface_, x_, at);
  const double distance = std::sqrt(nearest.distance_sq);
  const bool is_inside = outward.dot(place - nearest.point) < 0;
  const double depth = std::max(0.0, radius_ - (is_inside ? -distance : distance));
  // Over an edge or a vertex the normal is that of the distance, which does not jump.
  Vec3 normal = outward;
  if (distance > 1e-9) normal = (is_inside ? -1 : 1) / distance * (place - nearest.point);
  dragged_ += step;
  dragged_ -= normal.dot(dragged_) * normal;
  const double most = mu_ * depth, way = dragged_.norm();
  if (way > most) dragged_ *= most / way;
  return dragged_ - depth * normal;
}

double path_depth(const std::vector<TimedPoint>& path, FollowedMotion motion) {
  constexpr double kEvery = 0.005;  // [s]
  if (path.empty()) return 0;
  const auto looks = static_cast<int>(std::min(path.back().t - path.front().t, kMostSpan) / kEvery) + 1;
  double most = 0;
  for (int i = 0; i <= looks; ++i)
    most = std::max(most, motion.move_to(interpolate_path(path, path.front().t + i * kEvery)).norm());
  return most;
}

BandPowers path_powers(const std::vector<TimedPoint>& path, FollowedMotion motion, double rate_hz, double use) {
  SpectrumMeter meter(rate_hz, use, std::numeric_limits<double>::infinity());
  if (path.empty()) return meter.powers();
  const double end = std::min(path.back().t, path.front().t + kMostSpan);
  const auto ticks = static_cast<int>(std::llround((end - path.front().t) * rate_hz));
  for (int i = 0; i <= ticks; ++i) meter.add(motion.move_to(interpolate_path(path, path.front().t + i / rate_hz)));
  return meter.powers();
}

}  // namespace kt
