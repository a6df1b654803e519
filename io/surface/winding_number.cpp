#include "io/surface/winding_number.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace kt {
namespace {

constexpr int kLeaf = 8;      // triangles
constexpr double kFar = 2;    // radii
constexpr int kDeepest = 64;  // of a tree that halves

/// Solid angle of a triangle over 4 pi (van Oosterom and Strackee 1983).
double triangle_winding(const Mesh& surface, const Triangle& t, const Vec3& place) {
  const Vec3 a = node(surface.x, t[0]) - place, b = node(surface.x, t[1]) - place, c = node(surface.x, t[2]) - place;
  const double na = a.norm(), nb = b.norm(), nc = c.norm();
  const double volume = a.dot(b.cross(c));
  const double below = na * nb * nc + a.dot(b) * nc + b.dot(c) * na + c.dot(a) * nb;
  return std::atan2(volume, below) / (2 * std::numbers::pi);
}

}  // namespace

double winding_number(const Mesh& surface, const Vec3& place) {
  double sum = 0;
  for (const Triangle& t : surface.triangles) sum += triangle_winding(surface, t, place);
  return sum;
}

WindingNumber::WindingNumber(const Mesh& surface) : surface_(surface), order_(surface.triangles.size()) {
  std::iota(order_.begin(), order_.end(), 0);
  for (const Triangle& t : surface.triangles) {
    const Vec3 a = node(surface.x, t[0]), b = node(surface.x, t[1]), c = node(surface.x, t[2]);
    centroid_.emplace_back((a + b + c) / 3);
    area_.emplace_back(0.5 * (b - a).cross(c - a));
  }
  if (!order_.empty()) build(0, static_cast<int>(order_.size()));
}

int WindingNumber::build(int begin, int end) {
  const auto self = branches_.size();
  branches_.emplace_back();
  Branch b{Vec3::Zero(), Vec3::Zero(), Mat3::Zero(), 0, begin, end, 0};
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  double weight = 0;
  for (int k = begin; k < end; ++k) {
    const auto t = static_cast<std::size_t>(order_[static_cast<std::size_t>(k)]);
    const double area = area_[t].norm();
    weight += area;
    b.centre += area * centroid_[t];
    b.area += area_[t];
    low = low.cwiseMin(centroid_[t]);
    high = high.cwiseMax(centroid_[t]);
  }
  b.centre = weight > 0 ? Vec3(b.centre / weight) : Vec3(0.5 * (low + high));
  for (int k = begin; k < end; ++k) {
    const auto t = static_cast<std::size_t>(order_[static_cast<std::size_t>(k)]);
    b.spread += (centroid_[t] - b.centre) * area_[t].transpose();
    for (const int v : surface_.triangles[t]) b.radius = std::max(b.radius, (node(surface_.x, v) - b.centre).norm());
  }
  if (end - begin > kLeaf) {
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const int middle = begin + (end - begin) / 2;
    const auto along = [&](int t) { return std::pair(centroid_[static_cast<std::size_t>(t)][axis], t); };
    std::ranges::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end, {}, along);
    build(begin, middle);
    b.right = build(middle, end);
  }
  branches_[self] = b;
  return static_cast<int>(self);
}

double WindingNumber::at(const Vec3& place) const {
  if (branches_.empty()) return 0;
  double sum = 0;
  std::array<int, kDeepest> open;
  int count = 1;
  open[0] = 0;
  while (count > 0) {
    const int self = open[static_cast<std::size_t>(--count)];
    const Branch& b = branches_[static_cast<std::size_t>(self)];
    const Vec3 r = b.centre - place;
    const double distance_sq = r.squaredNorm();
    if (distance_sq > kFar * kFar * b.radius * b.radius) {
      const double cubed = distance_sq * std::sqrt(distance_sq);
      const double first = b.area.dot(r) / cubed;
      const double second = b.spread.trace() / cubed - 3 * r.dot(b.spread * r) / (cubed * distance_sq);
      sum += (first + second) / (4 * std::numbers::pi);
    } else if (b.right == 0) {
      for (int k = b.begin; k < b.end; ++k)
        sum += triangle_winding(
            surface_, surface_.triangles[static_cast<std::size_t>(order_[static_cast<std::size_t>(k)])], place);
    } else {
      open[static_cast<std::size_t>(count++)] = b.right;
      open[static_cast<std::size_t>(count++)] = self + 1;
    }
  }
  return sum;
}

}  // namespace kt
