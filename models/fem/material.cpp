#include "models/fem/material.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace kt {

#define MATERIAL(name, available, option, what) std::unique_ptr<Material> make_##name##_material(const Lame& lame);
#include "models/fem/materials.def"

std::vector<BackendInfo> material_backends() {
  return {
#define MATERIAL(name, available, option, what) {#name, what, available != 0, option},
#include "models/fem/materials.def"
  };
}

std::unique_ptr<Material> make_material(const std::string& name, const Lame& lame) {
  require_backend("material", name, material_backends());
#define MATERIAL(known, available, option, what) \
  if (name == #known) return make_##known##_material(lame);
#include "models/fem/materials.def"
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

}  // namespace kt
