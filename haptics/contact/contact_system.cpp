#include "haptics/contact/contact_system.hpp"

#include <algorithm>
#include <cmath>

namespace kt {
namespace {

/// Nearest point of the cone |p_t| <= mu p_m around m.
Vec3 project_to_cone(const Vec3& p, const Vec3& m, double mu) noexcept {
  const double p_m = m.dot(p);
  const Vec3 p_t = p - p_m * m;
  const double length = p_t.norm();
  if (length <= mu * p_m) return p;
  if (mu * length <= -p_m) return Vec3::Zero();
  const double along = (p_m + mu * length) / (1 + mu * mu);
  return along * (m + mu / length * p_t);
}

}  // namespace

double natural_residual(const ContactSystem& system, const Eigen::Ref<const VectorX>& p,
                        const Eigen::Ref<const VectorX>& u, std::span<const double> mu) noexcept {
  const int c = system.count();
  double largest_p = 0, largest_b = 0, impulse = 0, velocity = 0;  // squares: |p|, |b|, e and e / r
  for (int i = 0; i < c; ++i) {
    const Vec3 m = -system.normal[i], own = u.segment<3>(3 * i), p_i = p.segment<3>(3 * i);
    const double r = system.mass(i), u_m = m.dot(own), p_sq = p_i.squaredNorm();
    largest_p = std::max(largest_p, p_sq);
    largest_b = std::max(largest_b, system.velocity.segment<3>(3 * i).squaredNorm());
    if (r == 0) {  // immovable: nothing helps against overlap
      if (u_m < 0) velocity = std::max(velocity, u_m * u_m);
      continue;
    }
    if (u_m >= 0 && p_sq == 0) continue;
    const double u_t = (own - u_m * m).norm();
    const double e = (p_i - project_to_cone(p_i - r * (own + mu[i] * u_t * m), m, mu[i])).squaredNorm();
    impulse = std::max(impulse, e);
    velocity = std::max(velocity, e / (r * r));
  }
  const auto relative = [](double value, double scale) { return value > 0 ? (scale > 0 ? value / scale : 1.0) : 0.0; };
  return std::sqrt(std::max(largest_p > 0 ? relative(impulse, largest_p) : 0.0, relative(velocity, largest_b)));
}

}  // namespace kt
