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

/// The slip problem in the contact frame (m, t1, t2). With p_t = mu p_m d and u_m = 0, p_m = -b_m / D(d) and
/// D u_t = r(d); friction opposes sliding when r is antiparallel to d.
struct Slip {
  const Mat3& W;
  const Vec3& b;
  double mu;
  double D(const Eigen::Vector2d& d) const { return W(0, 0) + mu * W.block<1, 2>(0, 1).dot(d); }
  Eigen::Vector2d r(const Eigen::Vector2d& d) const {
    return D(d) * b.tail<2>() - b[0] * (W.block<2, 1>(1, 0) + mu * (W.bottomRightCorner<2, 2>() * d));
  }
  static double across(const Eigen::Vector2d& d, const Eigen::Vector2d& r) { return d.x() * r.y() - d.y() * r.x(); }
  double across_at(double angle) const {
    const Eigen::Vector2d d(std::cos(angle), std::sin(angle));
    return across(d, r(d));
  }
};

constexpr int kSamples = 24;  // a degree-two polynomial has at most four roots; pairs closer than this need a W with
                              // condition beyond 1e3 and both are then slip directions alike
constexpr double kPi = 3.14159265358979323846;

/// Root of the sign change between two angles: regula falsi, Illinois variant, to the last bits.
double refine(const Slip& slip, double low, double high, double f_low, double f_high) {
  for (int i = 0; i < 60 && high - low > 1e-15; ++i) {
    const double middle = i % 3 == 2 ? 0.5 * (low + high) : (low * f_high - high * f_low) / (f_high - f_low);
    if (!(middle > low && middle < high)) break;
    const double f = slip.across_at(middle);
    if (f == 0) return middle;
    if ((f > 0) == (f_low > 0)) {
      low = middle;
      f_low = f;
      f_high *= 0.5;
    } else {
      high = middle;
      f_high = f;
      f_low *= 0.5;
    }
  }
  return 0.5 * (low + high);
}

/// Unit direction of the friction impulse, or the one against the velocity without contact when none is found.
Eigen::Vector2d slip_direction(const Slip& slip) {
  static const auto kDirections = [] {
    std::array<Eigen::Vector2d, kSamples + 1> out;
    for (int i = 0; i <= kSamples; ++i)
      out[i] = {std::cos(2 * kPi * (i % kSamples) / kSamples), std::sin(2 * kPi * (i % kSamples) / kSamples)};
    return out;
  }();
  Eigen::Vector2d best = -slip.b.tail<2>();
  best = best.norm() > 0 ? Eigen::Vector2d(best.normalized()) : Eigen::Vector2d(1, 0);
  double strongest = 0;
  double f_low = Slip::across(kDirections[0], slip.r(kDirections[0]));
  for (int i = 0; i < kSamples; ++i) {
    const double f_high = Slip::across(kDirections[i + 1], slip.r(kDirections[i + 1]));
    if ((f_low <= 0) != (f_high <= 0)) {
      const double angle = refine(slip, 2 * kPi * i / kSamples, 2 * kPi * (i + 1) / kSamples, f_low, f_high);
      const Eigen::Vector2d d(std::cos(angle), std::sin(angle));
      const double along = d.dot(slip.r(d));
      if (slip.D(d) > 0 && along < strongest) {  // opposes the motion; of several, the most dissipative
        strongest = along;
        best = d;
      }
    }
    f_low = f_high;
  }
  return best;
}

}  // namespace

OneContactSolution solve_one_contact(const Mat3& W_world, const Vec3& b_world, const Vec3& normal,
                                     const Friction& friction) noexcept {
  const Mat3 frame = frame_of(-normal);
  const Vec3 b = frame.transpose() * b_world;
  if (b[0] >= 0) return {};  // the body leaves the tool by itself
  const Mat3 W = frame.transpose() * W_world * frame;
  const bool frictionless = friction.mu_static == 0;
  if (!frictionless) {
    const Vec3 p = -(W.inverse() * b);
    if (p[0] > 0 && p.tail<2>().norm() <= friction.mu_static * p[0]) return {frame * p, ContactMode::stick};
  }
  const double mu = friction.mu_kinetic;
  if (mu == 0)
    return {frame.col(0) * (-b[0] / W(0, 0)), frictionless ? ContactMode::slide : ContactMode::frictional_slide};
  const Slip slip{W, b, mu};
  const Eigen::Vector2d d = slip_direction(slip);
  const double p_m = -b[0] / std::max(slip.D(d), 1e-3 * W(0, 0));
  return {frame * Vec3(p_m, mu * p_m * d.x(), mu * p_m * d.y()), ContactMode::frictional_slide};
}

}  // namespace kt
