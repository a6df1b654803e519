#pragma once
// Where a simulated hand is to go, told by another thread some sixty times a second: a pointer on a screen. The slot
// between the two never makes either wait.
#include <algorithm>
#include <array>
#include <atomic>

#include "core/base/types.hpp"

namespace kt {

class MovedTarget {
 public:
  /// @param fastest  [m/s] that the target moves with at most, however far the pointer jumps: what patches are made for
  MovedTarget(const Vec3& start, double fastest) : x_(start), fastest_(fastest) { move(start); }

  /// Where it is to go [m]. From one thread at a time; what is not finite is left out.
  void move(const Vec3& to) noexcept {
    if (!to.allFinite()) return;
    const unsigned version = version_.load(std::memory_order_relaxed);
    version_.store(version + 1, std::memory_order_relaxed);  // odd: being written
    std::atomic_thread_fence(std::memory_order_release);
    for (std::size_t i = 0; i < 3; ++i) wanted_[i].store(to[static_cast<int>(i)], std::memory_order_relaxed);
    version_.store(version + 2, std::memory_order_release);
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
    const unsigned before = version_.load(std::memory_order_acquire);
    if (before % 2 == 1) return;
    Vec3 place;
    for (std::size_t i = 0; i < 3; ++i) place[static_cast<int>(i)] = wanted_[i].load(std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_acquire);
    if (version_.load(std::memory_order_relaxed) == before) newest_ = place;
  }

  std::array<std::atomic<double>, 3> wanted_{};
  std::atomic<unsigned> version_{0};
  Vec3 newest_ = Vec3::Zero(), x_;  // of the ticking thread
  double fastest_;
};

}  // namespace kt
