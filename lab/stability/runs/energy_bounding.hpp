#pragma once
// The other way to a stable wall: the force changes by no more per way than the device's own damping can take back.
//
// A held force gives 1/2 |df| |way| more than the spring had in each tick, and |df| (1/2 + T_d / h) |way| with a delay;
// the device takes b way^2 / h at least. So |df| <= b / (h/2 + T_d) |way| keeps every tick passive (after the
// energy-bounding algorithm of Kim and Ryu 2010: the same bound of the energy that holding gives, without their terms
// for friction). The device's damping must be known.
#include "core/base/types.hpp"

namespace kt {

/// At one device. No allocation, no clock.
class EnergyBounding {
 public:
  /// @param damping  b of the device [N s/m], > 0   @param h, delay [s]
  EnergyBounding(double damping, double h, double delay);

  /// The force to write at a tick that found the device at x [m], when the body asks for `wanted` [N].
  Vec3 tick(const Vec3& x, const Vec3& wanted) noexcept;

 private:
  double stiffest_;
  Vec3 x_ = Vec3::Zero(), force_ = Vec3::Zero(), wanted_ = Vec3::Zero();
  bool started_ = false;
};

}  // namespace kt
