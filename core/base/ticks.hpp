#pragma once
// Times in ticks: what lasts a time must not last a number of ticks, as `local.rate_hz` goes from 250 Hz to 10 kHz.
#include <algorithm>
#include <cmath>

namespace kt {

/// Ticks in a time [s] at a rate [Hz], rounded; at least `least`, at most `most`.
inline int ticks_in(double seconds, double rate_hz, int least = 1, int most = 1 << 30) noexcept {
  return static_cast<int>(
      std::clamp(std::round(seconds * rate_hz), static_cast<double>(least), static_cast<double>(most)));
}

}  // namespace kt
