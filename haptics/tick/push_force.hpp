#pragma once
// What the hand feels while the body is pushed off a tool that was inside it. The push can end far from where it began,
// and a coarse surface may fold on its way: the force that is felt grows and falls by small steps until it is the local
// model's again.
#include "core/base/types.hpp"

namespace kt {

class PushForce {
 public:
  /// @param h  tick [s]
  explicit PushForce(double h = 1e-3) noexcept : ms_(1e3 * h) {}

  /// The tool was found inside; from its first touch on, steps are limited.
  void begin() noexcept {
    touched_ = touched_ && is_on_;
    is_on_ = true;
  }

  /// The force of this tick as the hand shall feel it [N]: `force` itself where it is within a step of the last one.
  /// @param touches  the tool is in contact
  /// @param pushes   the push goes on: not before it has ended, and the force has caught up, does the limit end
  Vec3 apply(const Vec3& force, bool touches, bool pushes) noexcept;

  bool is_on() const noexcept { return is_on_; }

 private:
  bool is_on_ = false, touched_ = false;
  Vec3 last_ = Vec3::Zero();
  double ms_;  // of a tick
};

}  // namespace kt
