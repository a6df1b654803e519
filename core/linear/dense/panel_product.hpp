#pragma once
// A dense matrix that is multiplied with one vector after another, a thousand times a second: such a product waits for
// memory, so the matrix is laid out in the order in which it is read.
#include <vector>

#include "core/base/types.hpp"

namespace kt {

/// Panels of kRows rows, one after another, each column by column; the last panel is filled up with zeros.
class PanelMatrix {
 public:
  static constexpr int kRows = 32;
  PanelMatrix() = default;
  explicit PanelMatrix(const Eigen::Ref<const MatrixX>& matrix);

  Eigen::Index rows() const noexcept { return rows_; }
  Eigen::Index cols() const noexcept { return cols_; }
  bool empty() const noexcept { return rows_ == 0; }

  /// out = A x, (rows); every entry is the sum over the even columns and that over the odd ones, each in their order,
  /// whatever the processor. No allocation when `out` has its size; what it has beyond stays. `out` must not be `x`.
  void multiply(const VectorX& x, VectorX& out) const noexcept;

 private:
  Eigen::Index rows_ = 0, cols_ = 0;
  std::vector<double> values_;
};

}  // namespace kt
