#pragma once
// When the next refresh is due: sooner while the body bends away from what its local models made of it.
#include <limits>

namespace kt {

class RefreshPace {
 public:
  /// After an interval that ended at time t [s]. A body that gave way under the tool, as springs that buckle do, does
  /// so again where the tool goes: refreshes stay frequent for a while.
  /// @param error      of the normal force that the local model gave, relative, >= 0
  /// @param force      that it gave [N]
  /// @param tolerance  error from which refreshes come twice as often, up to four times
  void judge(double t, double error, double force, double tolerance) noexcept;

  /// Ticks until the next refresh, of `usual` ones.
  /// @param delay    of a local model on its way [s]
  /// @param rate_hz  of ticks
  int interval(int usual, double delay, double rate_hz) const noexcept;

  /// The same for a run whose time 0 is at time t of this one [s].
  RefreshPace from(double t) const noexcept {
    RefreshPace out = *this;
    out.gave_way_ -= t;
    return out;
  }

  /// The usual interval is divided by: 1 to 4.
  int haste() const noexcept { return haste_; }

 private:
  int haste_ = 1;
  double most_force_ = 0;                                       // at the end of an interval [N]
  double gave_way_ = -std::numeric_limits<double>::infinity();  // when the body did last [s]
};

}  // namespace kt
