#include "haptics/safety/delayed_forces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kt {
namespace {

constexpr double kRoundoff = 1e-12;  // of a delay that is a whole number of ticks
constexpr double kLongestDelay = 1;  // [s]

int whole_ticks(double ticks) { return static_cast<int>(ticks * (1 + kRoundoff)); }

}  // namespace

DelayedForces::DelayedForces(double h, double delay, double most)
    : h_(h), most_(std::clamp(std::max(delay, most), 0.0, kLongestDelay)), even_(std::numeric_limits<int>::max() / 2) {
  // Ticks that catch up after a late one are short: twice as many forces may be on their way.
  const auto room = static_cast<std::size_t>(2 * whole_ticks(most_ / h_)) + 2;
  written_.assign(room, Vec3::Zero());
  lasted_.assign(room, h_);
  set_delay(delay);
}

void DelayedForces::set_delay(double delay) noexcept {
  delay_ = std::clamp(delay, 0.0, most_);
  const double ticks = delay_ / h_;
  whole_ = whole_ticks(ticks);
  late_ = std::max(0.0, ticks - whole_);
}

Vec3 DelayedForces::acted(double dt) noexcept {
  lasted_.front() = dt;
  even_ = dt == h_ ? std::min(even_ + 1, std::numeric_limits<int>::max() / 2) : 0;
  const auto whole = static_cast<std::size_t>(whole_);
  if (even_ > whole_ + 1) return late_ * written_[whole + 1] + (1 - late_) * written_[whole];
  if (!(dt > 0)) return written_[whole];
  // A force that was written a while ago, and stood for some time, acts in that much of [delay, delay + dt] ago.
  Vec3 sum = Vec3::Zero();
  double age = 0;
  for (std::size_t i = 0; i < written_.size() && age < delay_ + dt; ++i) {
    const double end = i + 1 < written_.size() ? age + lasted_[i] : std::numeric_limits<double>::infinity();
    const double shared = std::min(end, delay_ + dt) - std::max(age, delay_);
    if (shared > 0) sum += shared / dt * written_[i];
    age = end;
  }
  return sum;
}

void DelayedForces::put(const Vec3& force) noexcept {
  std::move_backward(written_.begin(), written_.end() - 1, written_.end());
  std::move_backward(lasted_.begin(), lasted_.end() - 1, lasted_.end());
  written_.front() = force;
  lasted_.front() = h_;
}

}  // namespace kt
