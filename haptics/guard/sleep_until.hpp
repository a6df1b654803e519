#pragma once
// Sleep by the clock that never jumps.
#include <ctime>

#include <cstdint>

namespace kt {

/// Until that time of CLOCK_MONOTONIC [ns].
inline void sleep_until_ns(std::int64_t due) {
  const timespec at{static_cast<time_t>(due / 1'000'000'000), static_cast<long>(due % 1'000'000'000)};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr) != 0) {
  }
}

}  // namespace kt
