#include "haptics/guard/followed_pose.hpp"

#include <algorithm>

namespace kt {
namespace {

constexpr double kOldest = 5e-3;   // [s] an older pose shuts the gate: poses come more often, or stand still
constexpr double kNothing = 1e-9;  // [m], [rad] there and back again, but for rounding

double angle_between(const Quaternion& a, const Quaternion& b) noexcept {
  return a.coeffs() == b.coeffs() ? 0 : a.angularDistance(b);
}

}  // namespace

void FollowedPose::begin_at(const Vec3& tool) noexcept {
  tool_.x = tool;
  has_tool_ = was_away_ = true;
}

/// One that stood still for longer has not moved unseen: it may go as far as between two poses before.
bool FollowedPose::is_leap(const Pose& device, double dt) const noexcept {
  const double since = since_ <= kOldest ? since_ : std::max(interval_, dt);
  return (device.x - last_.x).norm() > kMostSpeed * scale_ * since ||
         angle_between(device.r, last_.r) > kMostTurn * since;
}

void FollowedPose::close_gap(double dt) noexcept {
  rests_ -= dt;
  if (rests_ > 0) return;
  const double size = gap_.norm(), left = std::max(0.0, size - kFollows * dt);
  gap_ = left > 0 ? Vec3(left / size * gap_) : Vec3(Vec3::Zero());
  turn_gap_ = std::max(0.0, turn_gap_ - kTurns * dt);
}

Pose FollowedPose::follow(const Pose& device, double dt) noexcept {
  since_ += dt;
  const bool is_gap = has_tool_ && (was_away_ || dt >= kLongest);
  const bool leaps = has_last_ && !is_gap && is_leap(device, dt);
  if (is_gap) rests_ = 0;
  if (is_gap || leaps) {
    gap_ = tool_.x - device.x;
    const Eigen::AngleAxisd turn(has_last_ ? Quaternion(tool_.r * device.r.conjugate()) : Quaternion::Identity());
    turn_axis_ = turn.axis();
    turn_gap_ = turn.angle() > kNothing ? turn.angle() : 0;
    if (gap_.norm() <= kNothing) gap_.setZero();
  }
  if (leaps) {
    ++jumps_;
    rests_ = kLongest;
    jumped_ += device.x - last_.x;
  }
  has_jumped_ = leaps || (has_jumped_ && !is_gap);
  was_away_ = false;
  close_gap(std::min(dt, kLongest));
  if (!is_on_the_way()) has_jumped_ = false;
  if (!has_last_ || device.x != last_.x || device.r.coeffs() != last_.r.coeffs()) {
    if (has_last_ && since_ <= kOldest) interval_ = since_;
    since_ = 0;
  }
  last_ = device;
  tool_.x = device.x + gap_;
  tool_.r = turn_gap_ > 0 ? Quaternion(Eigen::AngleAxisd(turn_gap_, turn_axis_)) * device.r : device.r;
  has_tool_ = has_last_ = true;
  return tool_;
}

}  // namespace kt
