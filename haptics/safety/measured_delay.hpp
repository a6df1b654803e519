#pragma once
// How late forces act at a device that says so: from its acknowledgements.
#include <array>

#include "haptics/device/haptic_device.hpp"

namespace kt {

/// No allocation, no clock; one thread at a time.
///
/// Reckons with the 99th percentile of the last kWindow acknowledgements, rounded up to a tick, and one tick more: a
/// passivity controller that is told a tick too much holds walls tenfold stiffer than one that is told the mean, one
/// that is told too little hardly any (docs/stability_haptics.md).
class MeasuredDelay {
 public:
  static constexpr int kWindow = 512, kEnough = 32;
  static constexpr double kMost = 0.1;        ///< [s] more is no delay but a stall, and is left out
  static constexpr double kUnknownTicks = 2;  ///< of a device that acknowledges nothing: one on the bus, one to hold

  /// @param h [s], > 0   @param fixed  what tool.path.device.delay_ms says [s]; below 0: measured
  explicit MeasuredDelay(double h, double fixed = -1) : h_(h), fixed_(fixed) {}

  /// A written force was acknowledged after so long [s]. Not a number, negative, or a stall: left out.
  void add(double seconds) noexcept;

  /// O(kWindow): ask a few times a second.
  DelayEstimate estimate() const noexcept;
  /// Acknowledgements that were left out.
  int left_out() const noexcept { return left_out_; }

 private:
  double h_, fixed_;
  std::array<float, kWindow> seconds_{};
  int count_ = 0, next_ = 0, left_out_ = 0;
};

}  // namespace kt
