#include "haptics/contact/one_contact.hpp"

#include <Eigen/LU>
#include <cmath>

namespace kt {
namespace {

/// Orthonormal frame with m as its first column (Duff et al. 2017, branch on the sign).
Mat3 frame_of(const Vec3& m) {
  const double sign = std::copysign(1.0, m.z());
  const double a = -1.0 / (sign + m.z()), b = m.x() * m.y() * a;
  Mat3 frame;
  frame.col(0) = m;
  frame.col(1) = Vec3(1 + sign * m.x() * m.x() * a, sign * b, -sign * m.x());
  frame.col(2) = Vec3(b, sign + m.y() * m.y() * a, -m.y());
  return frame;
}

using Vec2 = Eigen::Vector2d;

Vec2 turned(const Vec2& d) { return {-d.y(), d.x()}; }
double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// The slip problem in the contact frame (m, t1, t2). With p_t = mu p_m d and u_m = 0, p_m = -b_m / D(d) and
/// D u_t = r(d); friction opposes sliding when r is antiparallel to d: across(d) = 0 with d.r(d) <= 0.
struct Slip {
  const Mat3& W;
  const Vec3& b;
  double mu;
  double D(const Vec2& d) const { return W(0, 0) + mu * W.block<1, 2>(0, 1).dot(d); }
  Vec2 r(const Vec2& d) const {
    return D(d) * b.tail<2>() - b[0] * (W.block<2, 1>(1, 0) + mu * (W.bottomRightCorner<2, 2>() * d));
  }
  double across(const Vec2& d) const { return cross(d, r(d)); }
  /// Derivative of across by the angle of d.
  double across_slope(const Vec2& d) const {
    const Vec2 e = turned(d);
    const Vec2 change = mu * W.block<1, 2>(0, 1).dot(e) * b.tail<2>() - b[0] * mu * (W.bottomRightCorner<2, 2>() * e);
    return cross(e, r(d)) + cross(d, change);
  }
};

constexpr int kSamples = 24;  // a polynomial of degree two has at most four roots and as many extrema; two roots
                              // between neighbouring samples show in the slopes
constexpr double kPi = 3.14159265358979323846;
constexpr double kAligned = 1e-13;  // of |r|: the angle between friction and sliding, in radians

/// Newton from the last tick's or sweep's direction: nearly always the answer, in two or three steps.
bool polish(const Slip& slip, Vec2& d) {
  for (int i = 0; i < 6; ++i) {
    const Vec2 r = slip.r(d);
    const double f = cross(d, r);
    if (std::abs(f) <= kAligned * r.norm()) return d.dot(r) <= 0 && slip.D(d) > 0;
    const double slope = slip.across_slope(d);
    if (!(std::abs(f) < 0.5 * std::abs(slope))) return false;  // half a radian: not near a root
    d = (d - f / slope * turned(d)).normalized();
  }
  return false;
}

/// Root of the sign change between two directions less than a right angle apart: regula falsi on the chord, Illinois
/// variant with every third step a bisection, to the last bits.
Vec2 refine(const Slip& slip, const Vec2& from, const Vec2& to, double f_low, double f_high) {
  double low = 0, high = 1;
  const auto at = [&](double s) { return Vec2(((1 - s) * from + s * to).normalized()); };
  for (int i = 0; i < 60 && high - low > 1e-16; ++i) {
    const double s = i % 3 == 2 ? 0.5 * (low + high) : (low * f_high - high * f_low) / (f_high - f_low);
    if (!(s > low && s < high)) break;
    const double f = slip.across(at(s));
    if (f == 0) return at(s);
    if ((f > 0) == (f_low > 0)) {
      low = s;
      f_low = f;
      f_high *= 0.5;
    } else {
      high = s;
      f_high = f;
      f_low *= 0.5;
    }
  }
  return at(0.5 * (low + high));
}

/// Extremum between two directions whose slopes differ in sign, by bisection.
Vec2 turning_point(const Slip& slip, Vec2 low, Vec2 high, double slope_low) {
  for (int i = 0; i < 30; ++i) {
    const Vec2 middle = (low + high).normalized();
    ((slip.across_slope(middle) > 0) == (slope_low > 0) ? low : high) = middle;
  }
  return (low + high).normalized();
}

const std::array<Vec2, kSamples + 1> kDirections = [] {
  std::array<Vec2, kSamples + 1> out;
  for (int i = 0; i <= kSamples; ++i)
    out[i] = {std::cos(2 * kPi * (i % kSamples) / kSamples), std::sin(2 * kPi * (i % kSamples) / kSamples)};
  return out;
}();

/// Unit direction of the friction impulse: from `guess` if that is near one, else of all directions the most
/// dissipative root; against the velocity without contact when none is found.
Vec2 slip_direction(const Slip& slip, const Vec2& guess) {
  if (const double length = guess.norm(); length > 0) {
    Vec2 d = guess / length;
    if (polish(slip, d)) return d;
  }
  Vec2 best = -slip.b.tail<2>();
  best = best.norm() > 0 ? Vec2(best.normalized()) : Vec2(1, 0);
  double strongest = 0;
  const auto consider = [&](const Vec2& from, const Vec2& to, double f_low, double f_high) {
    const Vec2 d = refine(slip, from, to, f_low, f_high);
    const double along = d.dot(slip.r(d));
    if (slip.D(d) > 0 && along < strongest) {
      strongest = along;
      best = d;
    }
  };
  double f_low = slip.across(kDirections[0]), slope_low = slip.across_slope(kDirections[0]);
  for (int i = 0; i < kSamples; ++i) {
    const Vec2 &from = kDirections[i], &to = kDirections[i + 1];
    const double f_high = slip.across(to), slope_high = slip.across_slope(to);
    if ((f_low <= 0) != (f_high <= 0)) {
      consider(from, to, f_low, f_high);
    } else if (f_low * slope_low < 0 && f_high * slope_high > 0) {  // towards zero and back: beyond it?
      const Vec2 turn = turning_point(slip, from, to, slope_low);
      const double f_turn = slip.across(turn);
      if ((f_turn <= 0) != (f_low <= 0)) {
        consider(from, turn, f_low, f_turn);
        consider(turn, to, f_turn, f_high);
      }
    }
    f_low = f_high;
    slope_low = slope_high;
  }
  return best;
}

}  // namespace

OneContact::OneContact(const Mat3& W, const Vec3& normal) noexcept
    : frame_(frame_of(-normal)), W_(frame_.transpose() * W * frame_), inverse_(W_.inverse()) {}

OneContactSolution OneContact::solve(const Vec3& b_world, const Friction& friction, const Vec3& guess) const noexcept {
  const Vec3 b = frame_.transpose() * b_world;
  if (b[0] >= 0) return {};  // the body leaves the tool by itself
  const bool frictionless = friction.mu_static == 0;
  if (!frictionless) {
    const Vec3 p = -(inverse_ * b);
    if (p[0] > 0 && p.tail<2>().norm() <= friction.mu_static * p[0]) return {frame_ * p, ContactMode::stick};
  }
  const double mu = friction.mu_kinetic;
  if (mu == 0)
    return {frame_.col(0) * (-b[0] / W_(0, 0)), frictionless ? ContactMode::slide : ContactMode::frictional_slide};
  const Slip slip{W_, b, mu};
  const Vec2 d = slip_direction(slip, frame_.rightCols<2>().transpose() * guess);
  const double p_m = -b[0] / std::max(slip.D(d), 1e-3 * W_(0, 0));
  return {frame_ * Vec3(p_m, mu * p_m * d.x(), mu * p_m * d.y()), ContactMode::frictional_slide};
}

OneContactSolution solve_one_contact(const Mat3& W, const Vec3& b, const Vec3& normal, const Friction& friction,
                                     const Vec3& guess) noexcept {
  return OneContact(W, normal).solve(b, friction, guess);
}

}  // namespace kt
