#include "core/local/damping.hpp"

#include <cmath>

namespace kt {
bool is_diagonal(const SparseMatrix& m) {
  for (int c = 0; c < m.outerSize(); ++c)
    for (SparseMatrix::InnerIterator it(m, c); it; ++it)
      if (it.row() != c && it.value() != 0) return false;
  return true;
}

double damping_coupling(const LocalModel& model) {
  constexpr int kIterations = 15;
  if (model.dof() == 0) return 0;  // all of it is clamped
  if (!is_diagonal(model.mass) || !is_diagonal(model.stiffness)) return std::numeric_limits<double>::infinity();
  const VectorX diagonal = model.damping.diagonal();
  const double floor = 1e-12 * diagonal.maxCoeff();
  if (!(floor > 0)) return is_diagonal(model.damping) ? 0 : std::numeric_limits<double>::infinity();
  const VectorX scale = diagonal.cwiseMax(floor).cwiseSqrt().cwiseInverse();
  VectorX u(diagonal.size());
  for (Eigen::Index i = 0; i < u.size(); ++i) u[i] = std::cos(1.0 + static_cast<double>(i));  // nothing special
  const SparseMatrix& D = model.damping;
  const bool is_full = D.nonZeros() == D.size();  // then its numbers are those of a dense matrix, column by column
  const Eigen::Map<const MatrixX> full(D.valuePtr(), is_full ? D.rows() : 0, is_full ? D.cols() : 0);
  double norm = 0;
  for (int i = 0; i < kIterations; ++i) {
    u.normalize();
    const VectorX scaled = scale.cwiseProduct(u);
    const VectorX damped = is_full ? VectorX(full * scaled) : VectorX(D * scaled);
    u = scale.cwiseProduct(damped - diagonal.cwiseProduct(scaled));
    norm = u.norm();
    if (!(norm > 0)) break;
  }
  return norm;
}

void drop_coupling(LocalModel& model) { model.damping = SparseMatrix(VectorX(model.damping.diagonal()).asDiagonal()); }

}  // namespace kt
