#include "io/solid/cell_moments.hpp"

#include <Eigen/Eigenvalues>

#include "core/body/cut_tetrahedron.hpp"

namespace kt {
namespace {

/// Square root of a symmetric matrix, and its inverse.
std::array<Mat3, 2> roots_of(const Mat3& square) {
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(square);
  const Vec3 root = eigen.eigenvalues().cwiseMax(0).cwiseSqrt();
  return {eigen.eigenvectors() * root.asDiagonal() * eigen.eigenvectors().transpose(),
          eigen.eigenvectors() * root.cwiseInverse().asDiagonal() * eigen.eigenvectors().transpose()};
}

std::array<Vec3, 4> corners_of(int tetrahedron) {
  std::array<Vec3, 4> out;
  const auto steps = kuhn_corners(tetrahedron);
  for (std::size_t c = 0; c < 4; ++c) out[c] = Vec3(steps[c][0], steps[c][1], steps[c][2]);
  return out;
}

CellPoints gauss_points() {
  CellPoints out = CellPoints::Constant(kFarShare);
  out.diagonal().setConstant(kNearShare);
  return out;
}

}  // namespace

void CellMoments::add(double its_share, const Vec3& middle, const Mat3& spread) {
  share += its_share;
  first += its_share * middle;
  second += its_share * (spread + middle * middle.transpose());
}

Mat3 spread_of(const std::array<Vec3, 4>& corners) {
  const Vec3 middle = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
  Mat3 out = Mat3::Zero();
  for (const Vec3& corner : corners) out += (corner - middle) * (corner - middle).transpose() / 20;
  return out;
}

const CellMoments& whole_cell(int tetrahedron) {
  static const std::array<CellMoments, 6> all = [] {
    std::array<CellMoments, 6> out;
    for (int t = 0; t < 6; ++t) {
      const std::array<Vec3, 4> corners = corners_of(t);
      out[static_cast<std::size_t>(t)].add(1, 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]),
                                           spread_of(corners));
    }
    return out;
  }();
  return all[static_cast<std::size_t>(tetrahedron)];
}

CellPoints cell_points(int tetrahedron, const CellMoments& moments) {
  constexpr double kWhole = 1e-9, kNothing = 1e-3;
  const CellPoints gauss = gauss_points();
  if (moments.share > 1 - kWhole) return gauss;
  const CellMoments& whole = whole_cell(tetrahedron);
  const double nothing = kNothing * (1 - std::max(moments.share, 0.0));
  const double share = moments.share + nothing;
  const Vec3 middle = (moments.first + nothing * whole.first) / share;
  const Mat3 spread = (moments.second + nothing * whole.second) / share - middle * middle.transpose();
  // The whole cell's points, stretched: of all such maps the one that is symmetric where the whole cell is round.
  const auto [root, inverse] = roots_of(whole.second - whole.first * whole.first.transpose());
  const Mat3 stretch = root * roots_of(inverse * spread * inverse)[0] * inverse;
  const std::array<Vec3, 4> corners = corners_of(tetrahedron);
  CellPoints out;
  for (Eigen::Index q = 0; q < 4; ++q) {
    Vec3 off = -whole.first;
    for (std::size_t c = 0; c < 4; ++c) off += gauss(static_cast<Eigen::Index>(c), q) * corners[c];
    const std::array<double, 4> weights = kuhn_weights(tetrahedron, middle + stretch * off);
    out.col(q) = Eigen::Vector4d(weights.data());
  }
  return out;
}

}  // namespace kt
