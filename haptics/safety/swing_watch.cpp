#include "haptics/safety/swing_watch.hpp"

#include <algorithm>

namespace kt {

bool SwingWatch::add(double x, double dt) noexcept {
  constexpr double kTurns = 0.3;  // of kLeast: back by so much is a turn
  if (!started_) {
    started_ = true;
    low_ = high_ = x;
    return false;
  }
  lasted_ += dt;
  low_ = std::min(low_, x);
  high_ = std::max(high_, x);
  const double back = kTurns * kLeast;
  const bool turned_down = way_ >= 0 && x < high_ - back, turned_up = way_ <= 0 && x > low_ + back;
  if (!turned_down && !turned_up) return false;
  const double size = high_ - low_;
  const bool counts = way_ != 0 && size >= kLeast && lasted_ <= kLongest;
  way_ = turned_down ? -1 : 1;
  (turned_down ? low_ : high_) = x;
  lasted_ = 0;
  if (!counts) {
    count_ = 0;
    return false;
  }
  std::move(sizes_.begin() + 1, sizes_.end(), sizes_.begin());
  sizes_.back() = size;
  if (++count_ < kHalves || sizes_.back() < kGoesOn * sizes_[kHalves - 5]) return false;
  count_ = 0;
  return true;
}

}  // namespace kt
