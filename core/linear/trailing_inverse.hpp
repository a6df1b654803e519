#pragma once
// A block of the inverse of a factored matrix.
#include "core/linear/sparse_solver.hpp"

namespace kt {

/// The last `count` rows and columns of the inverse of the matrix that the solver factored last, which has `rows` of
/// them. Of a block solver that was asked to order these nodes last it is read off its factor; else solved for.
MatrixX trailing_inverse(const SparseSolver& solver, Eigen::Index rows, Eigen::Index count);

/// P A^-1 P^T of points that go with the last P.cols() rows alone, in less time where they are fewer.
MatrixX trailing_inverse(const SparseSolver& solver, Eigen::Index rows, const SparseMatrix& P);

}  // namespace kt
