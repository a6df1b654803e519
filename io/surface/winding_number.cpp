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

/// Sum of the solid angles of triangles over 4 pi (van Oosterom and Strackee 1983). Half of each is the angle of a
/// complex number: their product has the sum, but for whole turns, which are counted. So one arc tangent does for all.
class SolidAngles {
 public:
  void add(const VectorX& nodes, const Triangle& t, const Vec3& place) {
    const Vec3 a = node(nodes, t[0]) - place, b = node(nodes, t[1]) - place, c = node(nodes, t[2]) - place;
    const double na = a.norm(), nb = b.norm(), nc = c.norm();
    const double y = a.dot(b.cross(c));
    const double x = na * nb * nc + a.dot(b) * nc + b.dot(c) * na + c.dot(a) * nb;
    const double size = std::abs(x) + std::abs(y);
    if (!(size > 0)) return;  // at a corner
    const double re = (re_ * x - im_ * y) / size, im = (re_ * y + im_ * x) / size;
    if (im_ > 0 && y > 0 && std::signbit(im)) ++turns_;
    if (im_ < 0 && y < 0 && !std::signbit(im)) --turns_;
    const double scale = 1 / (std::abs(re) + std::abs(im));
    re_ = scale * re;
    im_ = scale * im;
  }
  double sum() const { return std::atan2(im_, re_) / (2 * std::numbers::pi) + turns_; }

 private:
  double re_ = 1, im_ = 0;
  int turns_ = 0;
};

/// Of a triangle, nearest to a place (Ericson, Real-Time Collision Detection, section 5.1.5).
Vec3 nearest_of(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, normal = ab.cross(ac);
  const double area_sq = normal.squaredNorm();
  if (area_sq > 0) {
    const Vec3 ap = p - a;
    const double v = ap.cross(ac).dot(normal), w = ab.cross(ap).dot(normal);
    if (v >= 0 && w >= 0 && v + w <= area_sq) return p - ap.dot(normal) / area_sq * normal;
  }
  const auto on_edge = [&p](const Vec3& from, const Vec3& to) -> Vec3 {
    const Vec3 along = to - from;
    const double length_sq = along.squaredNorm();
    return from + (length_sq > 0 ? std::clamp(along.dot(p - from) / length_sq, 0.0, 1.0) : 0) * along;
  };
  return std::ranges::min({on_edge(a, b), on_edge(b, c), on_edge(c, a)}, {},
                          [&p](const Vec3& at) { return (at - p).squaredNorm(); });
}

/// Where a segment passes through a triangle, 0 to 1; below 0: it does not.
double crossing(const Vec3& from, const Vec3& along, const Vec3& a, const Vec3& b, const Vec3& c) {
  constexpr double kRounding = 1e-9;
  const Vec3 ab = b - a, ac = c - a, across = along.cross(ac);
  const double volume = ab.dot(across);
  if (volume == 0) return -1;
  const Vec3 off = from - a;
  const double v = off.dot(across) / volume;
  if (v < -kRounding || v > 1 + kRounding) return -1;
  const Vec3 turned = off.cross(ab);
  const double w = along.dot(turned) / volume, t = ac.dot(turned) / volume;
  return w < -kRounding || v + w > 1 + kRounding || t > 1 ? -1 : t;
}

}  // namespace

double winding_number(const VectorX& x, std::span<const Triangle> triangles, const Vec3& place) {
  SolidAngles sum;
  for (const Triangle& t : triangles) sum.add(x, t, place);
  return sum.sum();
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
  double far = 0;
  SolidAngles near;
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
      far += (first + second) / (4 * std::numbers::pi);
    } else if (b.right == 0) {
      for (int k = b.begin; k < b.end; ++k)
        near.add(surface_.x, surface_.triangles[static_cast<std::size_t>(order_[static_cast<std::size_t>(k)])], place);
    } else {
      open[static_cast<std::size_t>(count++)] = b.right;
      open[static_cast<std::size_t>(count++)] = self + 1;
    }
  }
  return near.sum() + far;
}

/// Triangles of the branches whose balls are near.
template <class IsNear, class Take>
void WindingNumber::visit(const IsNear& is_near, const Take& take) const {
  if (branches_.empty()) return;
  std::array<int, kDeepest> open;
  int count = 1;
  open[0] = 0;
  while (count > 0) {
    const int self = open[static_cast<std::size_t>(--count)];
    const Branch& b = branches_[static_cast<std::size_t>(self)];
    if (!is_near(b.centre, b.radius)) continue;
    if (b.right == 0) {
      for (int k = b.begin; k < b.end; ++k) {
        const Triangle& t = surface_.triangles[static_cast<std::size_t>(order_[static_cast<std::size_t>(k)])];
        take(node(surface_.x, t[0]), node(surface_.x, t[1]), node(surface_.x, t[2]));
      }
      continue;
    }
    open[static_cast<std::size_t>(count++)] = b.right;
    open[static_cast<std::size_t>(count++)] = self + 1;
  }
}

/// The nearer half first.
std::optional<Vec3> WindingNumber::nearest(const Vec3& place, double most) const {
  if (branches_.empty()) return std::nullopt;
  std::optional<Vec3> out;
  double best_sq = most * most;
  struct Open {
    int branch;
    double least;  // distance of its ball, or less
  };
  const auto look = [&](int i) {
    const Branch& b = branches_[static_cast<std::size_t>(i)];
    return Open{i, (b.centre - place).norm() - b.radius};
  };
  std::array<Open, kDeepest> open;
  int count = 1;
  open[0] = look(0);
  while (count > 0) {
    const Open its = open[static_cast<std::size_t>(--count)];
    if (its.least > 0 && its.least * its.least >= best_sq) continue;
    const Branch& b = branches_[static_cast<std::size_t>(its.branch)];
    if (b.right == 0) {
      for (int k = b.begin; k < b.end; ++k) {
        const Triangle& t = surface_.triangles[static_cast<std::size_t>(order_[static_cast<std::size_t>(k)])];
        const Vec3 there = nearest_of(place, node(surface_.x, t[0]), node(surface_.x, t[1]), node(surface_.x, t[2]));
        if (!((there - place).squaredNorm() < best_sq)) continue;
        best_sq = (there - place).squaredNorm();
        out = there;
      }
      continue;
    }
    Open near = look(its.branch + 1), far = look(b.right);
    if (far.least < near.least) std::swap(near, far);
    open[static_cast<std::size_t>(count++)] = far;
    open[static_cast<std::size_t>(count++)] = near;
  }
  return out;
}

double WindingNumber::distance(const Vec3& place, double most) const {
  const std::optional<Vec3> its = nearest(place, most);
  return its ? (*its - place).norm() : most;
}

/// Shares of a way at which it passes through triangles, in no order.
template <class Take>
void WindingNumber::visit_along(const Vec3& a, const Vec3& b, const Take& take) const {
  const Vec3 along = b - a;
  const double length_sq = along.squaredNorm();
  visit(
      [&](const Vec3& centre, double radius) {
        const double t = length_sq > 0 ? std::clamp(along.dot(centre - a) / length_sq, 0.0, 1.0) : 0;
        return (a + t * along - centre).squaredNorm() <= radius * radius;
      },
      [&](const Vec3& p, const Vec3& q, const Vec3& r) {
        if (const double t = crossing(a, along, p, q, r); t >= 0) take(t);
      });
}

std::optional<double> WindingNumber::first_crossing(const Vec3& a, const Vec3& b) const {
  std::optional<double> out;
  visit_along(a, b, [&](double t) { out = std::min(t, out.value_or(t)); });
  return out;
}

bool WindingNumber::parts(const Vec3& a, const Vec3& b) const {
  constexpr double kThinnest = 1e-6;  // of the way: nearer ones are crossed at once
  const Vec3 along = b - a;
  std::vector<double> at;
  visit_along(a, b, [&](double t) { at.push_back(t); });
  std::ranges::sort(at);
  for (std::size_t i = 1; i < at.size(); ++i)
    if (at[i] - at[i - 1] > kThinnest && !is_inside(a + 0.5 * (at[i - 1] + at[i]) * along)) return true;
  return false;
}

}  // namespace kt
