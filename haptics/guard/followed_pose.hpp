#pragma once
// A tool never jumps: where poses are missing it follows the way that it missed at a speed that local models are made
// for. Where they leap as no hand moves, it rests first, as at a pose that is stale, until the gate is shut.

#include "core/base/types.hpp"
namespace kt {

class FollowedPose {
 public:
  static constexpr double kFollows = 0.25;   ///< [m/s] what local models are made for
  static constexpr double kTurns = 2.5;      ///< [rad/s] the same of a point 0.1 m away
  static constexpr double kMostSpeed = 3;    ///< [m/s] of a hand at a device: twice what a quick one does
  static constexpr double kMostTurn = 60;    ///< [rad/s] of a wrist: twice the same
  static constexpr double kLongest = 20e-3;  ///< [s] between two ticks; longer is a gap

  /// @param scale  way of the tool / way of the device
  explicit FollowedPose(double scale) : scale_(scale) {}

  /// The tool is there now, wherever the device is.
  void begin_at(const Vec3& tool) noexcept;
  /// The device's pose cannot be relied upon now: there is a gap until the next follow().
  void lose() noexcept { was_away_ = true; }

  /// @param device  finite, at the tool's scale   @param dt  since the last call [s], > 0
  Pose follow(const Pose& device, double dt) noexcept;

  bool is_on_the_way() const noexcept { return !gap_.isZero(0) || turn_gap_ > 0; }
  bool has_jumped() const noexcept { return has_jumped_; }  ///< and is on the way since
  int jumps() const noexcept { return jumps_; }             ///< so far
  /// Sum of the jumps [m]: the hand did not go there, and no energy went with it.
  const Vec3& jumped() const noexcept { return jumped_; }

 private:
  bool is_leap(const Pose& device, double dt) const noexcept;
  void close_gap(double dt) noexcept;

  double scale_;
  Pose tool_, last_;                // the device's
  Vec3 gap_ = Vec3::Zero();         // tool - device [m]
  Vec3 turn_axis_ = Vec3::UnitZ();  // tool = turn_gap_ about it, after the device's turn
  double turn_gap_ = 0;             // [rad]
  double rests_ = 0;                // for so long yet [s]
  double since_ = 0;                // the device's pose changed last [s]
  double interval_ = 0;             // between its last two changes that were near [s]
  Vec3 jumped_ = Vec3::Zero();
  int jumps_ = 0;
  bool has_tool_ = false, has_last_ = false, was_away_ = false, has_jumped_ = false;
};

}  // namespace kt
