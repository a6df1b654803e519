#include "core/fine/known_depths.hpp"

#include <algorithm>
#include <cmath>

namespace kt {

double KnownDepths::at(int cell, const CellPoint& point, double most) {
  if (known_.size() >= kMost) known_.clear();
  Depth& known = known_[{cell, point}];
  if (most > known.most && std::abs(known.depth) >= known.most)
    known = {material_.depth(cell, point.of(x_), most), most};
  return std::clamp(known.depth, -most, most);
}

}  // namespace kt
