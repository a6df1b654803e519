#pragma once
// Velocity from positions that an encoder reads in steps.
//
// The first difference of one tick is wrong by up to a step a tick: 10 mm/s for 10 um at 1 kHz. Over a window of n
// ticks it is n times finer, and n / 2 ticks late. Janabi-Sharifi, Hayward and Chen (2000): the window grows only while
// the path in it is a straight line as far as the encoder can tell.
#include <array>

#include "core/base/types.hpp"

namespace kt {

/// No allocation, noexcept.
class QuantizedVelocity {
 public:
  static constexpr int kMostTicks = 16;

  /// @param step  of the encoder [m], >= 0
  explicit QuantizedVelocity(double step = 0) : step_(step) {}

  /// A position [m], dt [s] after the one before.
  void put(const Vec3& x, double dt) noexcept;

  /// @param fine  [m/s] an error that does not matter: the window is as short as that allows; 0: as long as it may be
  /// @returns velocity [m/s]: end to end of the window; zero before there are two positions
  Vec3 velocity(double fine) const noexcept;
  /// Ticks of that window.
  int window(double fine) const noexcept;

 private:
  int back(int ticks) const noexcept { return (newest_ - ticks + kRoom) % kRoom; }
  bool is_straight(int ticks) const noexcept;

  static constexpr int kRoom = kMostTicks + 1;
  double step_;
  std::array<Vec3, kRoom> x_{};
  std::array<double, kRoom> t_{};  // [s] since the first
  int newest_ = -1, count_ = 0;
};

}  // namespace kt
