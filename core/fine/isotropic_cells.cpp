#include "core/fine/isotropic_cells.hpp"

#include <Eigen/SVD>
#include <cmath>

#include "core/base/error.hpp"

namespace kt {
namespace {

class IsotropicCells final : public Refinable {
 public:
  IsotropicCells(const Mesh& mesh, double young, double poisson, double retardation)
      : cells_(mesh.tetrahedra), young_(young), poisson_(poisson), retardation_(retardation) {}
  std::span<const int> cell_nodes(int cell) const override { return cells_[cell]; }
  Moduli moduli(TangentKind, const Mat3& F, const Mat3&) const override {
    return isotropic_moduli(young_, poisson_, nearest_rotation(F));
  }
  double stiffness_factor(const Vec3&) const override { return 1; }
  double retardation() const override { return retardation_; }

 private:
  const std::vector<Tetrahedron>& cells_;
  double young_, poisson_, retardation_;
};

}  // namespace

Moduli isotropic_moduli(double young, double poisson, const Mat3& rotation) {
  const double mu = young / (2 * (1 + poisson)), lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
  Moduli out;
  for (int l = 0; l < 3; ++l)
    for (int k = 0; k < 3; ++k)  // P = mu (dF + R dF^T R) + lambda tr(R^T dF) R
      for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 3; ++i)
          out(i + 3 * j, k + 3 * l) =
              mu * ((i == k && j == l) + rotation(i, l) * rotation(k, j)) + lambda * rotation(i, j) * rotation(k, l);
  return out;
}

Mat3 nearest_rotation(const Mat3& F) {
  const Eigen::JacobiSVD<Mat3> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 U = svd.matrixU();
  if ((U * svd.matrixV().transpose()).determinant() < 0) U.col(2) = -U.col(2);
  return U * svd.matrixV().transpose();
}

std::unique_ptr<Refinable> isotropic_cells(const DeformableModel& model) {
  const ModelInfo info = model.info();
  const auto named = [&](const char* key) {
    const auto found = info.parameters.find(key);
    return found == info.parameters.end() ? std::nan("") : found->second;
  };
  const double young = named("young"), poisson = named("poisson"), retardation = named("damping_stiffness");
  if (!(young > 0) || !(poisson > -1) || !(poisson < 0.5))
    throw InputError(text("fine patch: the model \"", info.type, "\" names young = ", young, " Pa, poisson = ", poisson,
                          ": must be > 0 and between -1 and 0.5; name both in info()"));
  const Mesh& mesh = model.mesh();
  if (mesh.tetrahedra.empty())
    throw InputError(text("fine patch: the body of model \"", info.type, "\" has no tetrahedra that could be refined"));
  std::vector<char> is_used(static_cast<std::size_t>(mesh.num_nodes()), 0);
  for (const Tetrahedron& t : mesh.tetrahedra)
    for (const int i : t) is_used[i] = 1;
  for (int i = 0; i < mesh.num_nodes(); ++i)
    if (!is_used[i])
      throw InputError(text("fine patch: node ", i, " of model \"", info.type,
                            "\" is a corner of no tetrahedron; a model of other cells must be Refinable"));
  return std::make_unique<IsotropicCells>(mesh, young, poisson, retardation >= 0 ? retardation : 0);
}

}  // namespace kt
