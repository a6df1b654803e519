#pragma once
#include <algorithm>

namespace kt {

/// Tetrahedra of a body turned inside out, as seen at its refreshes. Springs let them pass through flat, and not all
/// find their way back.
struct InvertedTetrahedra {
  int most = 0;     ///< at any refresh
  int last = 0;     ///< at the last one
  double from = 0;  ///< when the first were seen [s]

  /// @param t  of the refresh [s]
  void add(int count, double t) {
    if (count > 0 && most == 0) from = t;
    most = std::max(most, count);
    last = count;
  }
};

}  // namespace kt
