#include "haptics/safety/measured_delay.hpp"

#include <algorithm>
#include <cmath>

namespace kt {

void MeasuredDelay::add(double seconds) noexcept {
  if (!(seconds >= 0 && seconds <= kMost)) {
    ++left_out_;
    return;
  }
  seconds_[static_cast<std::size_t>(next_)] = static_cast<float>(seconds);
  next_ = (next_ + 1) % kWindow;
  count_ = std::min(count_ + 1, kWindow);
}

DelayEstimate MeasuredDelay::estimate() const noexcept {
  DelayEstimate out;
  if (count_ >= kEnough) {
    std::array<float, kWindow> sorted = seconds_;
    const auto end = sorted.begin() + count_;
    // The smallest value that this share of all does not exceed.
    const auto value = [&](double share) {
      const auto nth = sorted.begin() + static_cast<int>(std::ceil(share * count_)) - 1;
      std::nth_element(sorted.begin(), nth, end);
      return static_cast<double>(*nth);
    };
    out.p50 = value(0.5);
    out.p99 = value(0.99);
    out.measured = fixed_ < 0;
  }
  constexpr double kRoundoff = 1e-6;  // of a tick; acknowledgements are kept as floats
  const double ticks = out.measured ? std::ceil(out.p99 / h_ - kRoundoff) + 1 : kUnknownTicks;
  out.delay = fixed_ >= 0 ? fixed_ : ticks * h_;
  return out;
}

}  // namespace kt
