#include "tests/support/haptics_coulomb.hpp"

#include <Eigen/Eigenvalues>

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

ConvexSolution solve_by_convex_rounds(const MatrixX& W, const VectorX& b, const std::vector<Vec3>& normal,
                                      const std::vector<double>& mu, int rounds) {
  const double r = 1 / W.selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff();
  const auto tangential = [&](const VectorX& u, std::size_t i) {
    const Vec3 own = u.segment<3>(static_cast<Eigen::Index>(3 * i));
    return (own - normal[i].dot(own) * normal[i]).norm();
  };
  ConvexSolution out{VectorX::Zero(b.size()), 0};
  std::vector<double> speed(normal.size(), 0);
  for (int round = 0; round < rounds; ++round) {
    VectorX shifted = b;
    for (std::size_t i = 0; i < normal.size(); ++i)
      shifted.segment<3>(static_cast<Eigen::Index>(3 * i)) -= mu[i] * speed[i] * normal[i];
    VectorX y = out.p, before = out.p;
    double t = 1;
    for (int step = 0; step < 20000; ++step) {
      const VectorX gradient = W * y + shifted;
      VectorX next = y - r * gradient;
      for (std::size_t i = 0; i < normal.size(); ++i) {
        auto own = next.segment<3>(static_cast<Eigen::Index>(3 * i));
        own = project_to_cone(own, -normal[i], mu[i]);
      }
      const VectorX moved = next - before;
      if ((y - next).dot(moved) > 0) t = 1;  // uphill: without momentum from here (O'Donoghue and Candes 2015)
      const double t_next = 0.5 * (1 + std::sqrt(1 + 4 * t * t));
      y = next + (t - 1) / t_next * moved;
      t = t_next;
      before = next;
      if (moved.norm() <= 1e-14 * next.norm() && step > 2) break;
    }
    out.p = before;
    const VectorX u = W * out.p + b;
    out.change = 0;
    for (std::size_t i = 0; i < normal.size(); ++i) {
      const double now = tangential(u, i);
      out.change = std::max(out.change, std::abs(now - speed[i]) / b.lpNorm<Eigen::Infinity>());
      speed[i] = now;
    }
    if (out.change < 1e-12) break;
  }
  return out;
}

}  // namespace kt
