#pragma once
// Which force acts on a device, when it arrives a while after it was written and ticks may come late.
#include <vector>

#include "core/base/types.hpp"

namespace kt {

/// Forces on their way to the motors, newest first. No allocation after construction, noexcept.
class DelayedForces {
 public:
  /// @param h      tick as it should be [s], > 0
  /// @param delay  from writing until the force acts [s]   @param most  that set_delay() may be given [s]
  DelayedForces(double h, double delay, double most);

  /// Also while forces are on their way: these are thought to have been as late. Cut to [0, most].
  void set_delay(double delay) noexcept;
  double delay() const noexcept { return delay_; }

  /// Mean of the force that acted during the last dt [s], at whose start the newest one was written.
  Vec3 acted(double dt) noexcept;
  /// Written now.
  void put(const Vec3& force) noexcept;
  /// What was put last was this instead.
  void correct(const Vec3& force) noexcept { written_.front() = force; }

 private:
  double h_, most_, delay_ = 0;
  int whole_ = 0;    // ticks of the delay
  double late_ = 0;  // share of a tick in which an older force still acts
  int even_;         // ticks in a row that were as long as they should be
  std::vector<Vec3> written_;
  std::vector<double> lasted_;  // until the next one was written [s]
};

}  // namespace kt
