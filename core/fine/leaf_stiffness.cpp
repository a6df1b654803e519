#include "core/fine/leaf_stiffness.hpp"

#include <Eigen/LU>
#include <cmath>

#include "core/fine/fine_body.hpp"

namespace kt {
namespace {

/// K_ab += volume * sum_jl g_a[j] (dP/dF)(.j, .l) g_b[l], for a <= b.
void add_point(const Eigen::Matrix<double, 3, 10>& g, const Moduli& moduli, double volume, LeafMatrix& K) {
  for (int b = 0; b < 10; ++b) {
    const Vec3 gb = volume * g.col(b);
    Eigen::Matrix<double, 9, 3> stress;  // of unit motions of node b
    for (int k = 0; k < 3; ++k)
      stress.col(k) = gb[0] * moduli.col(k) + gb[1] * moduli.col(3 + k) + gb[2] * moduli.col(6 + k);
    for (int a = 0; a <= b; ++a)
      for (int k = 0; k < 3; ++k)
        K.block<3, 1>(3 * a, 3 * b + k) += g(0, a) * stress.block<3, 1>(0, k) + g(1, a) * stress.block<3, 1>(3, k) +
                                           g(2, a) * stress.block<3, 1>(6, k);
  }
}

}  // namespace

Eigen::Matrix<double, 3, 4> share_gradients(const std::array<Vec3, 4>& corners) {
  Mat3 edges;
  for (int i = 0; i < 3; ++i) edges.col(i) = corners[i + 1] - corners[0];
  Eigen::Matrix<double, 3, 4> out;
  out.rightCols<3>() = edges.inverse().transpose();
  out.col(0) = -out.rightCols<3>().rowwise().sum();
  return out;
}

Eigen::Matrix<double, 3, 10> quadratic_gradients(const Eigen::Matrix<double, 3, 4>& gradients,
                                                 const Eigen::Vector4d& shares) {
  Eigen::Matrix<double, 3, 10> out;
  for (int i = 0; i < 4; ++i) out.col(i) = (4 * shares[i] - 1) * gradients.col(i);
  for (int e = 0; e < 6; ++e) {
    const auto [i, j] = kCellEdges[e];
    out.col(4 + e) = 4 * (shares[i] * gradients.col(j) + shares[j] * gradients.col(i));
  }
  return out;
}

LeafMatrix leaf_stiffness(const std::array<Vec3, 4>& corners, const std::array<const Moduli*, kLeafPoints>& moduli) {
  const Eigen::Matrix<double, 3, 4> gradients = share_gradients(corners);
  const double six_volumes =
      std::abs((corners[1] - corners[0]).cross(corners[2] - corners[0]).dot(corners[3] - corners[0]));
  LeafMatrix out = LeafMatrix::Zero();
  for (int q = 0; q < kLeafPoints; ++q) {
    Eigen::Vector4d shares = Eigen::Vector4d::Constant(kFarShare);
    shares[q] = kNearShare;
    add_point(quadratic_gradients(gradients, shares), *moduli[q], six_volumes / (6 * kLeafPoints), out);
  }
  const LeafMatrix upper = out;
  out.triangularView<Eigen::StrictlyLower>() = upper.transpose();
  return out;
}

/// The moduli are the same everywhere: products of gradients are summed first, the upper triangle of them.
LeafMatrix leaf_stiffness(const std::array<Vec3, 4>& corners, const Moduli& moduli, std::span<const LeafPoint> points) {
  const Eigen::Matrix<double, 3, 4> gradients = share_gradients(corners);
  const double volume =
      std::abs((corners[1] - corners[0]).cross(corners[2] - corners[0]).dot(corners[3] - corners[0])) / 6;
  LeafMatrix products = LeafMatrix::Zero();
  for (const LeafPoint& p : points) {
    const Eigen::Matrix<double, 3, 10> g = quadratic_gradients(gradients, p.shares);
    for (int b = 0; b < 10; ++b)
      for (int l = 0; l < 3; ++l)
        products.col(3 * b + l).head(3 * b + 3) += p.weight * volume * g(l, b) * g.reshaped().head(3 * b + 3);
  }
  LeafMatrix out = LeafMatrix::Zero();
  for (int b = 0; b < 10; ++b)
    for (int a = 0; a <= b; ++a) {
      auto K = out.block<3, 3>(3 * a, 3 * b);
      for (int l = 0; l < 3; ++l)
        for (int j = 0; j < 3; ++j) K += products(3 * a + j, 3 * b + l) * moduli.block<3, 3>(3 * j, 3 * l);
    }
  const LeafMatrix upper = out;
  out.triangularView<Eigen::StrictlyLower>() = upper.transpose();
  return out;
}

}  // namespace kt
