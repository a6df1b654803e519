// The body's lowest vibrations, and how it yields to the patch at rest (static correction): global motion from few
// coordinates, exact at rest, poor where the patch moves against its neighbourhood above the highest vibration kept.
#include <Spectra/SymGEigsShiftSolver.h>

#include "core/base/error.hpp"
#include "core/local/subspace.hpp"

namespace kt {
namespace {

/// (K - shift M)^-1 and M in the shape that Spectra wants.
class Inverse {
 public:
  using Scalar = double;
  explicit Inverse(const FreeBody& body) : body_(body) {}
  Eigen::Index rows() const { return body_.mass.rows(); }
  Eigen::Index cols() const { return body_.mass.cols(); }
  void set_shift(double shift) {
    if (!solver_->factor(SparseMatrix(body_.stiffness - shift * body_.mass)))
      throw IndefiniteTangent("modal: the body's stiffness is not positive definite");
  }
  void perform_op(const double* in, double* out) const {
    Eigen::Map<VectorX>(out, rows()) = solver_->solve(MatrixX(Eigen::Map<const VectorX>(in, rows())));
  }

 private:
  const FreeBody& body_;
  std::unique_ptr<SparseSolver> solver_ = make_sparse_solver();
};

class MassProduct {
 public:
  using Scalar = double;
  explicit MassProduct(const SparseMatrix& mass) : mass_(mass) {}
  Eigen::Index rows() const { return mass_.rows(); }
  Eigen::Index cols() const { return mass_.cols(); }
  void perform_op(const double* in, double* out) const {
    Eigen::Map<VectorX>(out, rows()) = mass_ * Eigen::Map<const VectorX>(in, rows());
  }

 private:
  const SparseMatrix& mass_;
};

/// Just below zero, so that a body that is free to move has a factorization too: one hertz.
constexpr double kShift = -40;

}  // namespace

MatrixX lowest_vibrations(const FreeBody& body, int count) {
  const int n = body.dofs.size();
  count = std::min(count, n - 1);
  Inverse inverse(body);
  MassProduct mass(body.mass);
  Spectra::SymGEigsShiftSolver<Inverse, MassProduct, Spectra::GEigsMode::ShiftInvert> lanczos(
      inverse, mass, count, std::min(n, 2 * count + 20), kShift);
  lanczos.init();
  if (lanczos.compute(Spectra::SortRule::LargestMagn, 1000, 1e-8) < count)
    throw RunError(text("modal: only some of ", count, " vibrations found"));
  return lanczos.eigenvectors();
}

LocalModel reduce_modal(const TangentModel& tangent, SurfacePatch patch, const ContactSite&,
                        const ReduceOptions& options) {
  const FreeBody body(tangent);
  const MatrixX at_rest = responses(body, patch, {0}), vibrations = lowest_vibrations(body, options.modes);
  MatrixX motions(at_rest.rows(), at_rest.cols() + vibrations.cols());
  motions << at_rest, vibrations;
  LocalModel out = confine(tangent, body, std::move(patch), orthonormal_motions(body.mass, std::move(motions), 1e-8));
  out.reducer = "modal";
  return out;
}

}  // namespace kt
