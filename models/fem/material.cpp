#include "models/fem/material.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

namespace kt {

#define MATERIAL(name, available, option, what) std::unique_ptr<Material> make_##name##_material(const Lame& lame);
#include "models/fem/materials.def"
#undef MATERIAL

std::vector<BackendInfo> material_backends() {
  return {
#define MATERIAL(name, available, option, what) {#name, what, available != 0, option},
#include "models/fem/materials.def"
#undef MATERIAL
  };
}

std::unique_ptr<Material> make_material(const std::string& name, const Lame& lame) {
  require_backend("material", name, material_backends());
#define MATERIAL(known, available, option, what) \
  if (name == #known) return make_##known##_material(lame);
#include "models/fem/materials.def"
#undef MATERIAL
  return nullptr;
}

Mat9 Material::definite_tangent(const Mat3& F) const {
  const Mat9 exact = tangent(F);
  const Eigen::LLT<Mat9> definite(exact + 1e-12 * exact.norm() * Mat9::Identity());
  if (definite.info() == Eigen::Success) return exact;  // most elements, most of the time: fifty times cheaper
  const Eigen::SelfAdjointEigenSolver<Mat9> eigen(exact);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() * eigen.eigenvectors().transpose();
}

Lame lame(double young, double poisson) {
  return {young * poisson / ((1 + poisson) * (1 - 2 * poisson)), young / (2 * (1 + poisson))};
}

void add_contracted(const Mat9& dP, const Gradients& g, double volume, Eigen::Ref<MatrixX> stiffness) {
  for (Eigen::Index b = 0; b < g.cols(); ++b) {
    Eigen::Matrix<double, 9, 3> right = Eigen::Matrix<double, 9, 3>::Zero();
    for (int l = 0; l < 3; ++l) right += (volume * g(l, b)) * dP.middleCols<3>(3 * l);
    for (Eigen::Index a = 0; a < g.cols(); ++a)
      for (int j = 0; j < 3; ++j) stiffness.block<3, 3>(3 * a, 3 * b) += g(j, a) * right.middleRows<3>(3 * j);
  }
}

void Material::add_stiffness(const Mat3& F, bool definite, const Gradients& g, double volume,
                             Eigen::Ref<MatrixX> stiffness) const {
  add_contracted(definite ? definite_tangent(F) : tangent(F), g, volume, stiffness);
}

namespace {

Mat3 rotation_by_svd(const Mat3& F) {
  const Eigen::JacobiSVD<Mat3> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 U = svd.matrixU();
  const Mat3 R = U * svd.matrixV().transpose();
  if (R.determinant() > 0) return R;
  U.col(2) *= -1;  // the smallest stretch takes the reflection
  return U * svd.matrixV().transpose();
}

}  // namespace

/// tr(S) is the largest of tr(Q^T F) over all rotations Q, and so the largest root of the characteristic polynomial of
/// Horn's 4 x 4 quaternion matrix, p(t) = t^4 - 2 |F|^2 t^2 - 8 J t + |F|^4 - 4 |cof F|^2 (Horn 1987; Theobald 2005).
/// Newton from above descends to it; R is its derivative by F.
Mat3 rotation_of(const Mat3& F) {
  const Mat3 cof = cofactor(F);
  const double I = F.squaredNorm(), J = F.col(0).dot(cof.col(0)), c = I * I - 4 * cof.squaredNorm();
  double t = std::sqrt(3 * I);  // no root is above
  for (int i = 0; i < 20; ++i) {
    const double slope = 4 * (t * (t * t - I) - 2 * J);
    const double step = (t * (t * (t * t - 2 * I) - 8 * J) + c) / slope;
    if (!(slope > 0)) return rotation_by_svd(F);
    t -= step;
    if (std::abs(step) < 1e-9 * t) {                   // one more would change nothing: it squares
      const double divisor = t * (t * t - I) - 2 * J;  // 2 (s1 + s2)(s2 + s3)(s3 + s1)
      if (!(divisor > 1e-3 * t * t * t)) break;
      return ((t * t + I) * F + 2 * t * cof - 2 * F * (F.transpose() * F)) / divisor;
    }
  }
  return rotation_by_svd(F);
}

Mat3 cofactor(const Mat3& F) {
  Mat3 out;
  out << F.col(1).cross(F.col(2)), F.col(2).cross(F.col(0)), F.col(0).cross(F.col(1));
  return out;
}

Mat9 cofactor_tangent(const Mat3& F) {
  // cof column i = F_j x F_k with (i, j, k) cyclic: its derivative by column j is -[F_k]x, by column k it is [F_j]x.
  Mat9 out = Mat9::Zero();
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    out.block<3, 3>(3 * i, 3 * j) = -cross_matrix(F.col(k));
    out.block<3, 3>(3 * i, 3 * k) = cross_matrix(F.col(j));
  }
  return out;
}

}  // namespace kt
