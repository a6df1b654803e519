#pragma once
// Watches the energy at the device, and takes back what the loop gave away: time-domain passivity observer and
// controller (Hannaford and Ryu 2002).
//
// A force that is held over a tick does not know where the hand goes meanwhile: pressing out of a spring it gives
// 1/2 (f_before - f) . way more than the spring had, in every tick. While a body is pressed in, its own stored energy
// hides that from the observer of the whole energy, so what the hold gives is counted by itself, too (the reference
// energy of Ryu, Preusche, Hannaford and Hirzinger 2005, with the trapezoid rule for the body's own energy).
#include <array>
#include <limits>
#include <optional>

#include "core/base/types.hpp"
#include "haptics/safety/delayed_forces.hpp"
#include "haptics/safety/quantized_velocity.hpp"

namespace kt {

struct PassivityOptions {
  double most_damping = 0;  ///< that the controller may add [N s/m]; 0: it only watches
  double h = 1e-3;          ///< tick [s]
  double delay = 0;         ///< until a written force acts [s]
  double max_force = std::numeric_limits<double>::infinity();  ///< that the device can give [N]
  double most_delay = 0;    ///< that set_delay() may be given [s]; less than `delay`: that
  bool axes_apart = false;  ///< the normal's debt and the tangent's are counted and paid by themselves
  double encoder_step = 0;  ///< [m]; > 0: the damper's velocity is that of QuantizedVelocity, not a tick's difference
};

/// What is known at a tick beside the position.
struct PortKnowledge {
  std::optional<Vec3> normal{};    ///< of the contact, of length one; none: the direction of the force
  std::optional<Vec3> velocity{};  ///< of the device itself [m/s]; none: from its positions
};

/// At one device; for torques with angles in place of positions (TurnSum): [N m], [rad], [N m s/rad]. No allocation
/// after construction, no clock.
class PassivityControl {
 public:
  explicit PassivityControl(const PassivityOptions& o);

  /// The force to write at a tick that found the device at x [m], when the body asks for `wanted` [N]. What the device
  /// cannot give the hand has never felt: a spring that is cut to the limit is counted as it was cut.
  /// @param dt  since the tick before [s], > 0; first overload: as it should be
  Vec3 tick(const Vec3& x, const Vec3& wanted) noexcept { return tick(x, wanted, o_.h); }
  Vec3 tick(const Vec3& x, const Vec3& wanted, double dt, const PortKnowledge& known = {}) noexcept;

  /// What later stages left of the force that tick() returned, before the next tick: that is counted, and the part of
  /// the body's spring that they cut off is one that the hand has never felt. Not called: all of it was given.
  void written(const Vec3& force) noexcept;

  /// From now on, until a written force acts [s]; at most PassivityOptions::most_delay.
  void set_delay(double delay) noexcept { forces_.set_delay(delay); }
  double delay() const noexcept { return forces_.delay(); }

  double taken() const { return taken_; }  ///< from the hand so far [J]; negative: the hand was given energy
  double least() const { return least_; }  ///< smallest so far [J]
  double most() const { return most_; }    ///< largest so far [J]
  double debt() const { return debt_[0] + debt_[1]; }  ///< that the hold gave away and was not taken back, now [J]
  double debt(int axis) const { return debt_[axis]; }  ///< 0: normal, or of all when they are not apart; 1: tangent
  double most_debt() const { return most_debt_; }    ///< largest sum that the hold gave away and was not taken back [J]
  double given_by_hold() const { return by_hold_; }  ///< all that the hold gave away, less what was taken back [J]
  int damped_ticks() const { return damped_ticks_; }
  bool limited() const { return limited_; }    ///< the last tick's force was cut to what the device can give
  double damping() const { return damping_; }  ///< of the last tick, the larger of the two axes' [N s/m]

 private:
  using Axes = std::array<Vec3, 2>;
  Axes split(const Vec3& v) const noexcept;
  void count(const Vec3& cut) noexcept;
  double damping_for(double owed, double square, double felt_square, double dt) noexcept;
  Vec3 damper(const Vec3& way, const Vec3& change, double dt, const PortKnowledge& known) noexcept;

  PassivityOptions o_;
  DelayedForces forces_;
  QuantizedVelocity velocity_;
  Vec3 x_ = Vec3::Zero(), force_ = Vec3::Zero();
  Vec3 normal_ = Vec3::UnitZ();
  bool started_ = false, limited_ = false;
  double share_ = 1;  // that later stages left of the last force
  double taken_ = 0, least_ = 0, most_ = 0, most_debt_ = 0, by_hold_ = 0, damping_ = 0;
  std::array<double, 2> debt_{};
  int damped_ticks_ = 0;
  /// The tick that was counted last: what written() counts once more.
  struct Counted {
    Vec3 way = Vec3::Zero(), acted = Vec3::Zero(), spring = Vec3::Zero();  ///< spring: sum at the tick's two ends [N]
    std::array<double, 2> debt{};
    double by_hold = 0, most_debt = 0;
    Vec3 wanted = Vec3::Zero(), out = Vec3::Zero();
  } last_;
};

/// The way that a tool has turned, as a vector: what PassivityControl takes for a position.
class TurnSum {
 public:
  /// @returns sum of the rotation vectors from tick to tick, in the world [rad]; its work with a torque is the tool's
  Vec3 add(const Quaternion& r) noexcept;
  const Vec3& sum() const noexcept { return sum_; }

 private:
  std::optional<Quaternion> before_;
  Vec3 sum_ = Vec3::Zero();
};

}  // namespace kt
