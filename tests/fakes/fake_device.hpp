#pragma once
// What the stand-ins of makers' libraries have in common: a stylus that the test moves, faults that it switches on, and
// all that the device was given. The test finds it with dlsym: fake_device().
#include <time.h>

#include <array>
#include <atomic>
#include <cstdint>

namespace kt::fake {

inline std::int64_t now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

enum class Fault { none, nan, hang, dead, gone, uncalibrated, saturated };

/// A force [N] that the device was given, and when.
struct Given {
  std::int64_t at_ns;
  double f[3];
};

struct Device {
  std::array<std::atomic<double>, 3> x{};  ///< [m]
  std::atomic<Fault> fault{Fault::none};
  std::atomic<int> count{1};  ///< how many are connected
  std::atomic<int> buttons{0};
  std::atomic<int> forces_off{0};  ///< cause, where the device has one
  std::atomic<int> wrong{-1};      ///< of its status: the flag that is not as it should be
  std::atomic<int> styles{4};      ///< of calibration
  std::atomic<bool> is_force_on{false};
  std::atomic<int> opened{0}, closed{0};
  std::atomic<bool> is_bad_pose_asked{false};  ///< the driver has read a NaN
  // What it got: written by its own servo alone; read up to `given`.
  static constexpr std::size_t kMost = 200'000;
  std::array<Given, kMost> log;
  std::atomic<std::size_t> given{0};

  void get(double fx, double fy, double fz) {
    const std::size_t i = given.load(std::memory_order_relaxed);
    if (i == kMost) return;
    log[i] = {now_ns(), {fx, fy, fz}};
    given.store(i + 1, std::memory_order_release);
  }
};

inline void sleep_until_ns(std::int64_t at) {
  const timespec until{at / 1'000'000'000, at % 1'000'000'000};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
}

}  // namespace kt::fake
