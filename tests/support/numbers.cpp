#include "tests/support/numbers.hpp"

#include <random>

namespace kt {

MatrixX central_differences(const std::function<VectorX(const VectorX&)>& f, const VectorX& x, double eps) {
  MatrixX out(f(x).size(), x.size());
  VectorX moved = x;
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    moved[i] = x[i] + eps;
    const double above = moved[i];
    out.col(i) = f(moved);
    moved[i] = x[i] - eps;
    out.col(i) = (out.col(i) - f(moved)) / (above - moved[i]);
    moved[i] = x[i];
  }
  return out;
}

double relative_error(const MatrixX& a, const MatrixX& b) {
  const double scale = b.norm();
  return (a - b).norm() / (scale > 0 ? scale : 1);
}

VectorX random_vector(Eigen::Index n, unsigned seed) {
  std::mt19937_64 bits(seed);  // its bits are fixed by the standard; those of the distributions are not
  VectorX out(n);
  for (double& value : out) value = std::ldexp(static_cast<double>(bits() >> 11), -52) - 1;
  return out;
}

MatrixX random_positive_definite(Eigen::Index n, unsigned seed) {
  const MatrixX a = random_vector(n * n, seed).reshaped(n, n);
  return MatrixX::Identity(n, n) + a * a.transpose() / static_cast<double>(n);
}

}  // namespace kt
