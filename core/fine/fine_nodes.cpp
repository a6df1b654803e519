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

/// Where it is, or the free slot that it would take. There are slots.
std::size_t FineNodes::slot_of(const CellPoint& point) const {
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = CellPointHash()(point) & mask;
  while (slots_[slot] >= 0 && points_[static_cast<std::size_t>(slots_[slot])] != point) slot = (slot + 1) & mask;
  return slot;
}

void FineNodes::widen() {
  constexpr std::size_t kFirst = 1024;
  slots_.assign(std::max(kFirst, 2 * slots_.size()), -1);
  for (int i = 0; i < size(); ++i) slots_[slot_of(points_[static_cast<std::size_t>(i)])] = i;
}

int FineNodes::at(const CellPoint& point) {
  if (2 * points_.size() >= slots_.size()) widen();
  int& number = slots_[slot_of(point)];
  if (number >= 0) return number;
  number = size();
  points_.push_back(point);
  return number;
}

int FineNodes::find(const CellPoint& point) const { return slots_.empty() ? -1 : slots_[slot_of(point)]; }

void FineNodes::clear() {
  points_.clear();
  std::ranges::fill(slots_, -1);
}

}  // namespace kt
