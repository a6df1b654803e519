#pragma once
// CPU time, whatever else runs on the machine.
#include <ctime>

namespace kt {

/// 0 where the thread of the clock has ended.
inline double clock_ms(clockid_t clock) noexcept {
  timespec now{};
  if (clock_gettime(clock, &now) != 0) return 0;
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

inline double process_time_ms() noexcept { return clock_ms(CLOCK_PROCESS_CPUTIME_ID); }  ///< of all threads
inline double thread_time_ms() noexcept { return clock_ms(CLOCK_THREAD_CPUTIME_ID); }    ///< of this one
inline double thread_time_us() noexcept { return 1e3 * thread_time_ms(); }

}  // namespace kt
