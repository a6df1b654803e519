#include "haptics/tick/push_force.hpp"

namespace kt {
namespace {

constexpr double kStep = 0.1;  // [N] in a millisecond, from nothing: what a soft body's push stays below
constexpr double kGrowth =
    0.05;  // of the last force, in a millisecond: below what people tell apart, and 1 kN is there after 0.15 s

}  // namespace

Vec3 PushForce::apply(const Vec3& force, bool touches, bool pushes) noexcept {
  if (!is_on_) return force;
  if (touches && !touched_) {
    touched_ = true;
    last_.setZero();
  }
  if (!touched_) {
    is_on_ = pushes;
    return force;
  }
  const Vec3 change = force - last_;
  const double most = ms_ * (kStep + kGrowth * last_.norm()), size = change.norm();
  if (size <= most) {
    is_on_ = pushes;
    return last_ = force;
  }
  return last_ += most / size * change;
}

}  // namespace kt
