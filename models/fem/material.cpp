#include "models/fem/material.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <limits>

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

LaneMat3 Material::lane_stress(const LaneMat3& F) const {
  LaneMat3 out;
  for (int lane = 0; lane < Lanes::kCount; ++lane) set_lane(out, lane, stress(get_lane(F, lane)));
  return out;
}

void Material::add_lane_stiffness(const LaneMat3& F, bool definite, std::span<const LaneVec3> g, const Lanes& volume,
                                  std::span<LaneMat3> blocks) const {
  for (int lane = 0; lane < Lanes::kCount; ++lane) {
    const Mat3 shape = get_lane(F, lane);
    const Mat9 dP = definite ? definite_tangent(shape) : tangent(shape);
    auto block = blocks.begin();
    for (std::size_t b = 1; b < g.size(); ++b) {
      const Vec3 gb = volume[lane] * get_lane(g[b], lane);
      Eigen::Matrix<double, 9, 3> right = Eigen::Matrix<double, 9, 3>::Zero();
      for (int l = 0; l < 3; ++l) right += gb[l] * dP.middleCols<3>(3 * l);
      for (std::size_t a = 0; a < b; ++a, ++block) {
        Mat3 sum = get_lane(*block, lane);
        for (int j = 0; j < 3; ++j) sum += g[a][j][lane] * right.middleRows<3>(3 * j);
        set_lane(*block, lane, sum);
      }
    }
  }
}

namespace {

using std::abs, std::sqrt;

Mat3 rotation_by_svd(const Mat3& F) {
  if (!F.allFinite()) return Mat3::Constant(std::numeric_limits<double>::quiet_NaN());
  const Eigen::JacobiSVD<Mat3> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 U = svd.matrixU();
  const Mat3 R = U * svd.matrixV().transpose();
  if (R.determinant() > 0) return R;
  U.col(2) *= -1;  // the smallest stretch takes the reflection
  return U * svd.matrixV().transpose();
}

/// tr(S) is the largest of tr(Q^T F) over all rotations Q, and so the largest root of the characteristic polynomial of
/// Horn's 4 x 4 quaternion matrix, p(t) = t^4 - 2 |F|^2 t^2 - 8 J t + |F|^4 - 4 |cof F|^2 (Horn 1987; Theobald 2005).
/// Newton from above descends to it; R is its derivative by F. False where the root is nearly double.
template <class T>
bool rotation_by_newton(const Mat3Of<T>& F, Mat3Of<T>& R) {
  const Mat3Of<T> cof = cofactor(F);
  const T I = F.squaredNorm(), J = F.col(0).dot(cof.col(0)), c = I * I - T(4) * cof.squaredNorm();
  T t = sqrt(T(3) * I);  // no root is above
  for (int i = 0; i < 20; ++i) {
    const T slope = T(4) * (t * (t * t - I) - T(2) * J);
    if (!all_less(T(0), slope)) return false;
    const T step = (t * (t * (t * t - T(2) * I) - T(8) * J) + c) / slope;
    t -= step;
    if (all_less(abs(step), T(1e-9) * t)) {          // one more would change nothing: it squares
      const T divisor = t * (t * t - I) - T(2) * J;  // 2 (s1 + s2)(s2 + s3)(s3 + s1)
      if (!all_less(T(1e-3) * t * t * t, divisor)) return false;
      const T one = T(1) / divisor;
      R = ((t * t + I) * one) * F + (T(2) * t * one) * cof - (T(2) * one) * (F * (F.transpose() * F));
      return true;
    }
  }
  return false;
}

}  // namespace

Mat3 rotation_of(const Mat3& F) {
  Mat3 R;
  return rotation_by_newton(F, R) ? R : rotation_by_svd(F);
}

LaneMat3 rotation_of(const LaneMat3& F) {
  LaneMat3 R;
  if (!rotation_by_newton(F, R))
    for (int lane = 0; lane < Lanes::kCount; ++lane) set_lane(R, lane, rotation_of(get_lane(F, lane)));
  return R;
}

/// a x b = cross_matrix(a) b.
static Mat3 cross_matrix(const Vec3& a) {
  Mat3 m;
  m << 0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0;
  return m;
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
