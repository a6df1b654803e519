#pragma once
// Watches the energy at the device, and takes back what the loop gave away: time-domain passivity observer and
// controller (Hannaford and Ryu 2002).
//
// A force that is held over a tick does not know where the hand goes meanwhile: pressing out of a spring it gives
// 1/2 (f_before - f) . way more than the spring had, in every tick. While a body is pressed in, its own stored energy
// hides that from the observer of the whole energy, so what the hold gives is counted by itself, too (the reference
// energy of Ryu, Preusche, Hannaford and Hirzinger 2005, with the trapezoid rule for the body's own energy).
#include <algorithm>
#include <cmath>
#include <vector>

#include "haptics/device/haptic_device.hpp"

namespace kt {

struct PassivityOptions {
  double most_damping = 0;  ///< that the controller may add [N s/m]; 0: it only watches
  double h = 1e-3;          ///< tick [s]
  double delay = 0;         ///< until a written force acts [s]
  double max_force = std::numeric_limits<double>::infinity();  ///< that the device can give [N]
};

/// At one device. No allocation after construction, no clock.
class PassivityControl {
 public:
  explicit PassivityControl(const PassivityOptions& o) : o_(o) {
    const double ticks = std::max(0.0, o.delay) / o.h;
    late_ = ticks - static_cast<double>(static_cast<long>(ticks * (1 + 1e-12)));
    late_ = std::max(0.0, late_);
    written_.assign(static_cast<std::size_t>(ticks * (1 + 1e-12)) + 2, Vec3::Zero());
  }

  /// The force to write at a tick that found the device at x [m], when the body asks for `wanted` [N]. What the device
  /// cannot give the hand has never felt: a spring that is cut to the limit is counted as it was cut.
  Vec3 tick(const Vec3& x, const Vec3& wanted) noexcept {
    const DeviceInfo limits{.max_force = o_.max_force};
    bool cut = false, damper_cut = false;
    const Vec3 force = safe_force(wanted, limits, cut);
    const Vec3 way = started_ ? Vec3(x - x_) : Vec3(Vec3::Zero());
    started_ = true;
    x_ = x;
    // The force that acted during the last tick: its newest part came `delay` late.
    const std::size_t n = written_.size();
    const Vec3 acted = late_ * written_[n - 1] + (1 - late_) * written_[n - 2];
    const double given = acted.dot(way), had = 0.5 * (force_ + force).dot(way);
    taken_ -= given;
    least_ = std::min(least_, taken_);
    most_ = std::max(most_, taken_);
    constexpr double kRoundoff = 1e-12;
    by_hold_ += given - had;
    debt_ = std::max(0.0, debt_ + given - had - kRoundoff * std::abs(had));
    most_debt_ = std::max(most_debt_, debt_);
    const Vec3 change = force - force_;
    force_ = force;
    const Vec3 out = safe_force(force - damping_for(way, change) * way / o_.h, limits, damper_cut);
    limited_ = cut || damper_cut;
    std::move_backward(written_.begin(), written_.end() - 1, written_.end());
    written_.front() = out;
    return out;
  }

  double taken() const { return taken_; }            ///< from the hand so far [J]; negative: the hand was given energy
  double least() const { return least_; }            ///< smallest so far [J]
  double most() const { return most_; }              ///< largest so far [J]
  double most_debt() const { return most_debt_; }    ///< largest sum that the hold gave away and was not taken back [J]
  double given_by_hold() const { return by_hold_; }  ///< all that the hold gave away, less what was taken back [J]
  int damped_ticks() const { return damped_ticks_; }
  bool limited() const { return limited_; }    ///< the last tick's force was cut to what the device can give
  double damping() const { return damping_; }  ///< of the last tick [N s/m]

 private:
  /// That dissipates the debt in one more tick like the last one; but no more than a few times what a spring as stiff
  /// as the one just felt needs. An old debt paid in one tick in which the encoder moved by one step is a blow.
  double damping_for(const Vec3& way, const Vec3& change) noexcept {
    constexpr double kHaste = 2;
    damping_ = 0;
    const double owed = std::max(debt_, -taken_);
    const double square = way.squaredNorm();
    if (o_.most_damping <= 0 || !(owed > 0) || !(square > 0)) return 0;
    const double felt = std::sqrt(change.squaredNorm() / square);
    damping_ = std::min({o_.most_damping, owed * o_.h / square, kHaste * felt * (0.5 * o_.h + o_.delay)});
    ++damped_ticks_;
    return damping_;
  }

  PassivityOptions o_;
  double late_ = 0;            // share of a tick in which an older force still acts
  std::vector<Vec3> written_;  // newest first
  Vec3 x_ = Vec3::Zero(), force_ = Vec3::Zero();
  bool started_ = false, limited_ = false;
  double taken_ = 0, least_ = 0, most_ = 0, debt_ = 0, most_debt_ = 0, by_hold_ = 0, damping_ = 0;
  int damped_ticks_ = 0;
};

}  // namespace kt
