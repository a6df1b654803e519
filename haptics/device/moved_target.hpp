#pragma once
// Where a simulated hand is to go, told by another thread some sixty times a second: a pointer on a screen. The slot
// between the two never makes either wait.
#include <algorithm>
#include <array>

#include "core/base/slot.hpp"
#include "core/base/types.hpp"

namespace kt {

class MovedTarget {
 public:
  /// @param fastest  [m/s] that the target moves with at most, however far the pointer jumps: what patches are made for
  MovedTarget(const Vec3& start, double fastest) : x_(start), fastest_(fastest) { move(start); }

  /// Where it is to go [m]. From one thread at a time; what is not finite is left out.
  void move(const Vec3& to) noexcept {
    if (!to.allFinite()) return;
    wanted_.put({to.x(), to.y(), to.z()});
  }

  /// The target at the end of the next h seconds [m]: towards the newest place, evenly over a sample's time. In the
  /// thread that ticks: no lock, no allocation.
  Vec3 step(double h) noexcept {
    constexpr double kSample = 1.0 / 60;  // [s] between two places
    read();
    const Vec3 way = newest_ - x_;
    const double length = way.norm(), most = std::min(fastest_ * h, length * std::min(1.0, h / kSample));
    if (length > 0) x_ += (most / length) * way;
    return x_;
  }
  const Vec3& now() const noexcept { return x_; }

 private:
  /// A place that is being written is taken in the next tick.
  void read() noexcept {
    std::array<double, 3> place;
    if (wanted_.read(place)) newest_ = {place[0], place[1], place[2]};
  }

  Slot<std::array<double, 3>> wanted_;
  Vec3 newest_ = Vec3::Zero(), x_;  // of the ticking thread
  double fastest_;
};

}  // namespace kt
