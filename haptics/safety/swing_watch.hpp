#pragma once
// Tells a swing that goes on from a hand that moves: faster than a hand does on purpose, and not dying out.
#include <array>

namespace kt {

/// Of one coordinate. No allocation, no clock.
class SwingWatch {
 public:
  /// @param x [m], dt [s] after the one before   @returns true when a swing has gone on for kHalves half swings; then
  /// it begins anew
  bool add(double x, double dt) noexcept;
  void reset() noexcept { *this = {}; }

  static constexpr int kHalves = 6;
  static constexpr double kLeast = 1e-4;        ///< [m] of a half swing: less is not felt as one
  static constexpr double kLongest = 1.0 / 15;  ///< [s] of a half swing: 7.5 Hz, faster than people tap
  static constexpr double kGoesOn = 0.95;       ///< the last half swing / the one four before

 private:
  bool started_ = false;
  int way_ = 0;  // 1: up, -1: down, 0: not known yet
  double low_ = 0, high_ = 0, lasted_ = 0;
  int count_ = 0;
  std::array<double, kHalves> sizes_{};  // oldest first
};

}  // namespace kt
