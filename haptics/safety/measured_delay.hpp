#pragma once
// How late forces act at a device that says so: from its acknowledgements.
#include <array>

namespace kt {

/// What a controller is told of a delay, and how much of it is known.
struct DelayEstimate {
  double delay = 0;         ///< [s] to reckon with
  double p50 = 0, p99 = 0;  ///< of the acknowledgements in the window [s]; 0 before there are enough
  bool measured = false;    ///< else fixed or unknown
};

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
