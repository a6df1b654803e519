#pragma once
// The types that every folder shares, as vectors, matrices, poses, node access in stacked arrays. SI units everywhere.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cstdint>

namespace kt {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using VectorX = Eigen::VectorXd;
using MatrixX = Eigen::MatrixXd;
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Quaternion = Eigen::Quaterniond;
using SparseMatrix = Eigen::SparseMatrix<double>;  ///< column-major, compressed when it leaves a function

using Triangle = std::array<int, 3>;     ///< node indices, counter-clockwise seen from outside
using Tetrahedron = std::array<int, 4>;  ///< node indices, positive volume: (b-a)x(c-a).(d-a) > 0

/// Where a rigid tool is.
struct Pose {
  Vec3 x = Vec3::Zero();                  ///< reference point, world frame [m]
  Quaternion r = Quaternion::Identity();  ///< unit, from the tool's frame to the world's

  bool is_finite() const noexcept { return x.allFinite() && r.coeffs().allFinite(); }
  bool operator==(const Pose& other) const noexcept { return x == other.x && r.coeffs() == other.r.coeffs(); }
};

/// Force and torque on it.
struct Wrench {
  Vec3 force = Vec3::Zero();   ///< [N]
  Vec3 torque = Vec3::Zero();  ///< about the tool's reference point [N m]
};

/// Rotation by |v| [rad] about v.
inline Quaternion rotation(const Vec3& v) {
  const double angle = v.norm();
  return angle > 0 ? Quaternion(Eigen::AngleAxisd(angle, v / angle)) : Quaternion::Identity();
}

/// Orientation over time of a tool that follows a script, a fixed one and an even spin about the reference point.
struct ToolTurn {
  Vec3 turn = Vec3::Zero();  ///< rotation vector at t = 0 [rad]
  Vec3 spin = Vec3::Zero();  ///< angular velocity [rad/s]

  Quaternion at(double t) const { return rotation(t * spin) * rotation(turn); }
};

/// The three entries of node i in a stacked array (x0 y0 z0 x1 y1 z1 ...).
inline auto node(VectorX& x, int i) { return x.segment<3>(3 * i); }
inline auto node(const VectorX& x, int i) { return x.segment<3>(3 * i); }

/// Key of a number in an order that is independent of the numbering, the same on every machine.
constexpr std::uint32_t mixed(int number) noexcept {
  auto h = static_cast<std::uint32_t>(number) + 0x9e3779b9u;
  for (int i = 0; i < 2; ++i) h = (h ^ (h >> 16)) * 0x45d9f3bu;
  return h ^ (h >> 16);
}

/// Sets all values of `matrix` to zero in the pattern of `pattern`. Keeps its storage when it has that pattern already,
/// judged by the size and the number of entries. Only for matrices that never had another pattern.
inline void set_zero(SparseMatrix& matrix, const SparseMatrix& pattern) {
  if (matrix.rows() == pattern.rows() && matrix.nonZeros() == pattern.nonZeros() && matrix.isCompressed())
    std::fill(matrix.valuePtr(), matrix.valuePtr() + matrix.nonZeros(), 0.0);
  else
    matrix = pattern;
}

}  // namespace kt
