#pragma once
#include <cstddef>

#include "core/local/certified_rates.hpp"

namespace kt {

constexpr std::size_t kBands = kCertifiedHz.size();

/// Mean squares about each of kCertifiedHz, of a force [N^2] or a motion [m^2].
struct BandPowers {
  double total = 0;                     ///< of the whole, with what lasts
  std::array<double, kBands> changing;  ///< of what changes within the use of a local model
};

}  // namespace kt
