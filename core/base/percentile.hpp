#pragma once
#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

namespace kt {

/// Value below which a share `p` of the sorted values lies (nearest rank); 0 for an empty list.
inline double percentile(std::span<const double> of, double p) {
  std::vector<double> values(of.begin(), of.end());
  if (values.empty()) return 0;
  const auto rank = static_cast<std::size_t>(std::ceil(p * static_cast<double>(values.size())));
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(std::min(values.size() - 1, rank > 0 ? rank - 1 : 0));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

}  // namespace kt
