#include "core/impedance.hpp"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/LU>
#include <numbers>

#include "core/error.hpp"

namespace kt {
namespace {

using Complex = std::complex<double>;
using ComplexVector = Eigen::VectorXcd;
using ComplexSparse = Eigen::SparseMatrix<Complex>;

/// The real factor applied to both parts, in the shape that Eigen's iterative solvers want.
class RealFactor {
 public:
  template <class Matrix>
  RealFactor& analyzePattern(const Matrix&) {
    return *this;
  }
  template <class Matrix>
  RealFactor& factorize(const Matrix&) {
    return *this;
  }
  template <class Matrix>
  RealFactor& compute(const Matrix&) {
    return *this;
  }
  Eigen::ComputationInfo info() const { return Eigen::Success; }
  template <class Vector>
  ComplexVector solve(const Vector& b) const {
    MatrixX parts(b.size(), 2);
    parts << ComplexVector(b).real(), ComplexVector(b).imag();
    const MatrixX x = solver->solve(parts);
    ComplexVector out(b.size());
    out.real() = x.col(0);
    out.imag() = x.col(1);
    return out;
  }
  const SparseSolver* solver = nullptr;
};

}  // namespace

std::vector<ComplexMat3> compliances(const LocalModel& model, std::span<const int> vertices, double hz) {
  const double w = 2 * std::numbers::pi * hz;
  const Eigen::MatrixXcd dynamic = (MatrixX(model.stiffness) - w * w * MatrixX(model.mass)).cast<Complex>() +
                                   Complex(0, w) * MatrixX(model.damping).cast<Complex>();
  Eigen::MatrixXcd rows(3 * static_cast<Eigen::Index>(vertices.size()), model.dof());
  for (std::size_t i = 0; i < vertices.size(); ++i)
    rows.middleRows(3 * static_cast<Eigen::Index>(i), 3) =
        MatrixX(model.basis.middleRows(3 * vertices[i], 3)).cast<Complex>();
  const Eigen::MatrixXcd motions = dynamic.partialPivLu().solve(rows.transpose());
  std::vector<ComplexMat3> out;
  for (Eigen::Index i = 0; i < rows.rows(); i += 3) out.emplace_back(rows.middleRows(i, 3) * motions.middleCols(i, 3));
  return out;
}

struct BodyCompliance::System {
  ComplexSparse dynamic;
  std::unique_ptr<SparseSolver> factor = make_sparse_solver();
  Eigen::BiCGSTAB<ComplexSparse, RealFactor> iteration;
};

BodyCompliance::BodyCompliance(const FreeBody& body, double hz) : body_(body), system_(std::make_unique<System>()) {
  const double w = 2 * std::numbers::pi * hz;
  const SparseMatrix real = w * w * body.mass + w * body.damping + body.stiffness;
  if (!system_->factor->factor(real))
    throw RunError(text("impedance: the body is not positive definite at ", hz, " Hz"));
  system_->dynamic = (body.stiffness - w * w * body.mass).cast<Complex>();
  system_->dynamic += Complex(0, w) * body.damping.cast<Complex>();
  system_->iteration.preconditioner().solver = system_->factor.get();
  system_->iteration.setTolerance(1e-8);
  system_->iteration.setMaxIterations(500);
  system_->iteration.compute(system_->dynamic);
}
BodyCompliance::~BodyCompliance() = default;

ComplexMat3 BodyCompliance::at(int node) const {
  ComplexMat3 out;
  for (int c = 0; c < 3; ++c) {
    ComplexVector load = ComplexVector::Zero(body_.dofs.size());
    load[body_.dofs.to_free[3 * node + c]] = 1;
    const ComplexVector u = system_->iteration.solve(load);
    for (int r = 0; r < 3; ++r) out(r, c) = u[body_.dofs.to_free[3 * node + r]];
  }
  return out;
}

double impedance_error(const ComplexMat3& compliance, const ComplexMat3& body_compliance) {
  const ComplexMat3 exact = body_compliance.inverse();
  return (compliance.inverse() - exact).norm() / exact.norm();
}

}  // namespace kt
