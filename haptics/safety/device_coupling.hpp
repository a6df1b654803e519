#pragma once
// A spring between a device and the tool in the body: whatever the tool meets, the hand feels no more than the spring.
//
// A loop that is sampled every h and acts T_d late is passive up to a stiffness b / (h/2 + T_d) (Colgate and Schenkel
// 1997). In series with a coupling k_c below that, a body of any stiffness K is felt as k_c K / (k_c + K) (Colgate,
// Stanley and Brown 1995).
//
// The tool has no mass: coupling and body balance at it. The body's force is known only where the tool has been, so the
// balance is solved with the body's stiffness as it was felt on the last steps, times 1.5: a backward Euler step that
// converges for every stiffness between a third of that and all of it, and from above. Without contact the tool is the
// device: no lag, no force.
#include "core/base/types.hpp"
#include "haptics/safety/swing_watch.hpp"

namespace kt {

struct CouplingOptions {
  double stiffness = 0;  ///< k_c [N/m]; 0: no coupling, the tool is the device
  double damping = 0;    ///< beside the spring [N s/m]; it counts in full against the device's damping
  bool adapts = false;   ///< softer while the device swings on in contact: holds more when a device damps well and its
                         ///< delay is told wrong, less when it damps hardly (docs/stability_haptics.md)
};

/// Share of the device's damping that the coupling's stiffness uses.
constexpr double kCouplingShare = 0.8;
/// Of a device of which neither damping nor stiffness is known [N/m]: what a desktop device is sold for.
constexpr double kUnknownStiffness = 1000;

/// k_c that a device holds passively [N/m]: 0.8 b / (h/2 + delay), or its nominal stiffness if that is less.
/// @param device_damping [N s/m]; 0: unknown   @param nominal [N/m]; 0: unknown   @param h, delay [s]
double coupling_stiffness(double device_damping, double nominal, double h, double delay) noexcept;

/// At one device. In each tick tool(), then the body, then force(). No allocation, no clock.
class DeviceCoupling {
 public:
  explicit DeviceCoupling(const CouplingOptions& o);

  /// Where the tool goes in this tick, for a device that is at x [m], dt [s] after the tick before.
  Vec3 tool(const Vec3& x, double dt) noexcept;
  /// What the device is given [N], when the body gave `body_force` on the tool.
  /// @param normal  of the contact, of length one; zero: that of the force, whose friction then tilts it: a tool that
  ///                slides is dragged when the body is more than some ten times as stiff as the coupling
  Vec3 force(const Vec3& body_force, const Vec3& normal = Vec3::Zero()) noexcept;

  double stiffness() const noexcept { return k_; }  ///< now [N/m]
  Vec3 stretch() const noexcept { return e_; }      ///< tool - device [m]
  bool touches() const noexcept { return touches_; }
  int halvings() const noexcept { return halvings_; }

 private:
  /// Stiffness along some directions, from what steps of the tool did to the force: least squares that forgets.
  struct Felt {
    double work = 0, square = 0;  ///< sums of -df . s [J] and s . s [m^2]
    void add(const Vec3& step, const Vec3& df) noexcept;
    double stiffness() const noexcept { return square > 0 && work > 0 ? work / square : 0; }
  };
  void adapt(double dt) noexcept;
  Vec3 along(const Vec3& v) const noexcept { return v.dot(normal_) * normal_; }

  CouplingOptions o_;
  double k_;
  Vec3 x_ = Vec3::Zero(), tool_ = Vec3::Zero(), step_ = Vec3::Zero(), e_ = Vec3::Zero(), e_rate_ = Vec3::Zero();
  Vec3 body_ = Vec3::Zero(), normal_ = Vec3::UnitZ();
  Felt felt_normal_, felt_tangent_;
  bool started_ = false, touches_ = false;
  SwingWatch swing_;
  double away_ = 0;  // out of contact since [s]
  double goal_;      // that the stiffness goes to [N/m]
  int halvings_ = 0;
};

}  // namespace kt
