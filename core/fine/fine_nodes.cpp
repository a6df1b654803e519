#include "core/fine/fine_nodes.hpp"

#include <algorithm>

namespace kt {

bool CellPoint::lies_on(std::span<const int> corners) const {
  for (int k = 0; k < count; ++k)
    if (std::ranges::find(corners, corner[k]) == corners.end()) return false;
  return true;
}

CellPoint corner_point(int corner) { return {1, {corner}, {CellPoint::kOne}}; }

CellPoint middle(const CellPoint& a, const CellPoint& b) {
  CellPoint out;
  int i = 0, j = 0;
  while (i < a.count || j < b.count) {
    const bool takes_a = j == b.count || (i < a.count && a.corner[i] <= b.corner[j]);
    const bool takes_b = i == a.count || (j < b.count && b.corner[j] <= a.corner[i]);
    out.corner[out.count] = takes_a ? a.corner[i] : b.corner[j];
    out.weight[out.count] = ((takes_a ? a.weight[i] : 0) + (takes_b ? b.weight[j] : 0)) / 2;
    ++out.count;
    i += takes_a;
    j += takes_b;
  }
  return out;
}

int FineNodes::at(const CellPoint& point) {
  const auto [found, is_new] = number_.try_emplace(point, size());
  if (is_new) points_.push_back(point);
  return found->second;
}

int FineNodes::find(const CellPoint& point) const {
  const auto found = number_.find(point);
  return found == number_.end() ? -1 : found->second;
}

}  // namespace kt
