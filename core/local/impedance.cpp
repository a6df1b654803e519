#include "core/local/impedance.hpp"

#include <Eigen/LU>
#include <numbers>

#include "core/base/error.hpp"
#include "core/linear/sparse_product.hpp"

namespace kt {
namespace {

using Complex = std::complex<double>;

/// Real parts of some motions, then their imaginary parts, (n x 2k).
using Parts = RowMatrix;

Eigen::Array<Complex, 1, Eigen::Dynamic> dot(const Parts& u, const Parts& v) {
  const Eigen::Index k = u.cols() / 2;
  const auto sum = [](const auto& a, const auto& b) { return a.cwiseProduct(b).colwise().sum().eval(); };
  Eigen::Array<Complex, 1, Eigen::Dynamic> out(k);
  out.real() = sum(u.leftCols(k), v.leftCols(k)) - sum(u.rightCols(k), v.rightCols(k));
  out.imag() = sum(u.leftCols(k), v.rightCols(k)) + sum(u.rightCols(k), v.leftCols(k));
  return out;
}

/// y + x a, motion by motion.
Parts combine(const Parts& y, const Parts& x, const Eigen::Array<Complex, 1, Eigen::Dynamic>& a) {
  const Eigen::Index k = x.cols() / 2;
  const VectorX re = a.real().matrix(), im = a.imag().matrix();
  Parts out = y;
  out.leftCols(k) += x.leftCols(k) * re.asDiagonal();
  out.leftCols(k) -= x.rightCols(k) * im.asDiagonal();
  out.rightCols(k) += x.leftCols(k) * im.asDiagonal();
  out.rightCols(k) += x.rightCols(k) * re.asDiagonal();
  return out;
}

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
  SparseMatrix real, imaginary;  // of the dynamic stiffness
  std::unique_ptr<SparseSolver> factor = make_sparse_solver();
  Parts apply(const Parts& u) const {
    const Eigen::Index k = u.cols() / 2;
    Parts out = symmetric_times(real, u);
    const Parts damped = symmetric_times(imaginary, u);
    out.leftCols(k) -= damped.rightCols(k);
    out.rightCols(k) += damped.leftCols(k);
    return out;
  }
};

BodyCompliance::BodyCompliance(const FreeBody& body, double hz) : body_(body), system_(std::make_unique<System>()) {
  const double w = 2 * std::numbers::pi * hz;
  if (!system_->factor->factor(dynamic_stiffness(body, w)))
    throw RunError(text("impedance: the body is not positive definite at ", hz, " Hz"));
  system_->real = body.stiffness - w * w * body.mass;
  system_->imaginary = w * body.damping;
}
BodyCompliance::~BodyCompliance() = default;

/// Conjugate gradients for complex symmetric systems (COCG, van der Vorst and Melissen 1990), for all loads at once.
std::vector<ComplexMat3> BodyCompliance::at(std::span<const int> nodes, double rest) const {
  const auto k = static_cast<Eigen::Index>(3 * nodes.size());
  Parts residual = Parts::Zero(body_.force.size(), 2 * k), solution = residual;
  for (Eigen::Index c = 0; c < k; ++c) residual(body_.dofs.to_free[3 * nodes[c / 3] + c % 3], c) = 1;
  Parts direction = system_->factor->solve(residual);
  Eigen::Array<Complex, 1, Eigen::Dynamic> rz = dot(residual, direction);
  for (int step = 0; residual.colwise().norm().maxCoeff() > rest; ++step) {
    if (step == 1000) throw RunError("impedance: the body's motion was not found in 1000 steps");
    const Parts image = system_->apply(direction);
    const Eigen::Array<Complex, 1, Eigen::Dynamic> curvature = dot(direction, image);
    const auto length = (curvature == 0.0).select(0.0 * rz, rz / curvature).eval();
    solution = combine(solution, direction, length);
    residual = combine(residual, image, -length);
    const Parts z = system_->factor->solve(residual);
    const Eigen::Array<Complex, 1, Eigen::Dynamic> rz_new = dot(residual, z);
    direction = combine(z, direction, (rz == 0.0).select(0.0 * rz, rz_new / rz).eval());
    rz = rz_new;
  }
  std::vector<ComplexMat3> out(nodes.size());
  for (Eigen::Index c = 0; c < k; ++c)
    for (int r = 0; r < 3; ++r) {
      const int row = body_.dofs.to_free[3 * nodes[c / 3] + r];
      out[static_cast<std::size_t>(c / 3)](r, c % 3) = Complex(solution(row, c), solution(row, c + k));
    }
  return out;
}

double impedance_error(const ComplexMat3& compliance, const ComplexMat3& body_compliance) {
  const ComplexMat3 exact = body_compliance.inverse();
  return (compliance.inverse() - exact).norm() / exact.norm();
}

}  // namespace kt
