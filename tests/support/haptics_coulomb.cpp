#include "tests/support/haptics_coulomb.hpp"

namespace kt {
namespace {

double step_length(const MatrixX& W) { return 0.6 / W.norm(); }

/// K(p - r (u + mu |u_t| m))
VectorX next_iterate(const MatrixX& W, const VectorX& b, const std::vector<Vec3>& normal, double mu, const VectorX& p) {
  const VectorX u = W * p + b;
  const double r = step_length(W);
  VectorX out(p.size());
  for (std::size_t i = 0; i < normal.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(3 * i);
    const Vec3 m = -normal[i], own = u.segment<3>(at);
    const Vec3 u_t = own - m.dot(own) * m;
    out.segment<3>(at) = project_to_cone(p.segment<3>(at) - r * (own + mu * u_t.norm() * m), m, mu);
  }
  return out;
}

}  // namespace

Vec3 project_to_cone(const Vec3& p, const Vec3& m, double mu) {
  const double p_m = m.dot(p);
  const Vec3 p_t = p - p_m * m;
  const double length = p_t.norm();
  if (length <= mu * p_m) return p;
  if (mu * length <= -p_m) return Vec3::Zero();
  const double along = (p_m + mu * length) / (1 + mu * mu);
  return along * (m + mu / length * p_t);
}

double coulomb_residual(const MatrixX& W, const VectorX& b, const std::vector<Vec3>& normal, double mu,
                        const VectorX& p) {
  return (p - next_iterate(W, b, normal, mu, p)).norm() / (p.norm() + step_length(W) * b.norm());
}

VectorX project_iterate(const MatrixX& W, const VectorX& b, const std::vector<Vec3>& normal, double mu, int steps) {
  VectorX p = VectorX::Zero(b.size());
  for (int i = 0; i < steps; ++i) {
    const VectorX next = next_iterate(W, b, normal, mu, p);
    const bool done = (next - p).norm() <= 1e-15 * next.norm();
    p = next;
    if (done) break;
  }
  return p;
}

}  // namespace kt
