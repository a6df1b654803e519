#pragma once
// The vocabulary every folder shares: vectors, matrices, node access in stacked arrays. SI units everywhere.
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>

namespace kt {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using VectorX = Eigen::VectorXd;
using MatrixX = Eigen::MatrixXd;
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using SparseMatrix = Eigen::SparseMatrix<double>;  ///< column-major, compressed when it leaves a function

using Triangle = std::array<int, 3>;     ///< node indices, counter-clockwise seen from outside
using Tetrahedron = std::array<int, 4>;  ///< node indices, positive volume: (b-a)x(c-a).(d-a) > 0

/// The three entries of node i in a stacked array (x0 y0 z0 x1 y1 z1 ...).
inline auto node(VectorX& x, int i) { return x.segment<3>(3 * i); }
inline auto node(const VectorX& x, int i) { return x.segment<3>(3 * i); }

/// All values of `matrix` zero in the pattern of `pattern`; keeps its storage when it has that pattern already,
/// which is judged by the size and the number of entries: for matrices that only ever had this pattern.
inline void set_zero(SparseMatrix& matrix, const SparseMatrix& pattern) {
  if (matrix.rows() == pattern.rows() && matrix.nonZeros() == pattern.nonZeros() && matrix.isCompressed())
    std::fill(matrix.valuePtr(), matrix.valuePtr() + matrix.nonZeros(), 0.0);
  else
    matrix = pattern;
}

}  // namespace kt
