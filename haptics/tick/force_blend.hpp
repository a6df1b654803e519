#pragma once
// What the hand feels across a refresh: the difference between two local models, faded out over some ticks, and never
// at the cost of energy that hands did not put in.
#include <optional>

#include "core/base/types.hpp"

namespace kt {

class ForceBlend {
 public:
  /// @param h  haptic step [s]   @param duration  of a fade [s]
  ForceBlend(double h, double duration) noexcept;
  /// The next force comes from another model: where both touch, it goes on from the last one.
  /// @param before  force of that model in the last tick [N], of one that was run in beside the old one; none: their
  ///                difference shows in the next few ticks
  /// @param longer  times the usual fade: after a model that was in use for long, from which the next is far off
  void begin(const std::optional<Vec3>& before = {}, double longer = 1) noexcept {
    begins_ = true;
    before_ = before;
    longer_ = longer;
  }
  /// Before the first tick: it goes on from a force of another run [N]; none: it begins with none.
  void go_on_from(const std::optional<Vec3>& force) noexcept {
    touched_ = begins_ = force.has_value();
    last_ = force.value_or(Vec3::Zero());
  }
  /// The force of this tick as the hand shall feel it [N].
  /// @param force    of the local model [N]
  /// @param touches  the tool is in contact
  /// @param lost     contact ended at the edge of what the local model knows: the force fades instead of falling
  /// @param moved    by the tool in this tick [m]
  /// @param others   work done so far on the same body by other hands [J]: what one puts in another may take out
  Vec3 apply(const Vec3& force, bool touches, bool lost, const Vec3& moved, double others = 0) noexcept;
  double work() const noexcept { return work_; }  ///< done by the hand so far [J]

 private:
  double per_tick_;  // share of the difference that fades in a tick
  double longer_ = 1;
  double left_ = 0;  // share of the difference that is still there
  double work_ = 0;  // done by the hand so far [J]
  Vec3 last_ = Vec3::Zero(), difference_ = Vec3::Zero();
  std::optional<Vec3> before_;
  int settling_ = 0;  // ticks that are left
  bool begins_ = false, touched_ = false, fading_out_ = false;
};

}  // namespace kt
