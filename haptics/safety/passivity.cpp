#include "haptics/safety/passivity.hpp"

#include <algorithm>
#include <cmath>

#include "haptics/device/haptic_device.hpp"

namespace kt {

PassivityControl::PassivityControl(const PassivityOptions& o)
    : o_(o), forces_(o.h, o.delay, o.most_delay), velocity_(o.encoder_step) {}

Vec3 PassivityControl::tick(const Vec3& x, const Vec3& wanted, double dt, const PortKnowledge& known) noexcept {
  const DeviceInfo limits{.max_force = o_.max_force};
  bool cut = false, damper_cut = false;
  const Vec3 force = safe_force(wanted, limits, cut);
  const Vec3 way = started_ ? Vec3(x - x_) : Vec3(Vec3::Zero());
  started_ = true;
  x_ = x;
  if (o_.axes_apart) {
    if (known.normal)
      normal_ = *known.normal;
    else if (const double size = force.norm(); size > 0)
      normal_ = force / size;
  }
  const Vec3 shown = share_ < 1 ? Vec3(share_ * force) : force;  // as far as later stages did not cut the last one
  last_ = {way, forces_.acted(dt), force_ + shown, debt_, by_hold_, most_debt_, force, force};
  taken_ -= last_.acted.dot(way);
  least_ = std::min(least_, taken_);
  most_ = std::max(most_, taken_);
  count(Vec3::Zero());
  const Vec3 change = shown - force_;
  force_ = shown;
  last_.out = safe_force(force - damper(way, change, dt, known), limits, damper_cut);
  limited_ = cut || damper_cut;
  forces_.put(last_.out);
  return last_.out;
}

void PassivityControl::written(const Vec3& force) noexcept {
  const double square = last_.out.squaredNorm();
  const double share = square > 0 ? std::clamp(force.dot(last_.out) / square, 0.0, 1.0) : share_;
  if (force == last_.out && share_ == 1) return;
  // The damper was cut as the rest was; what else is missing is missing of the spring.
  const Vec3 spring = force == last_.out ? last_.wanted : Vec3(force + share * (last_.wanted - last_.out));
  share_ = force == last_.out ? 1 : share;
  forces_.correct(force);
  count(spring - force_);
  last_.spring += spring - force_;
  force_ = spring;
  last_.wanted += force - last_.out;
  last_.out = force;
}

/// The part that the hold gave of the last tick's work, when its spring was cut by so much at the end.
void PassivityControl::count(const Vec3& cut) noexcept {
  constexpr double kRoundoff = 1e-12;
  const Vec3 spring = last_.spring + cut;
  const Axes way = split(last_.way);
  by_hold_ = last_.by_hold;
  for (std::size_t i = 0; i < (o_.axes_apart ? 2u : 1u); ++i) {
    const double given = last_.acted.dot(way[i]), had = 0.5 * spring.dot(way[i]);
    by_hold_ += given - had;
    debt_[i] = std::max(0.0, last_.debt[i] + given - had - kRoundoff * std::abs(had));
  }
  most_debt_ = std::max(last_.most_debt, debt());
}

PassivityControl::Axes PassivityControl::split(const Vec3& v) const noexcept {
  if (!o_.axes_apart) return {v, Vec3::Zero()};
  const Vec3 along = v.dot(normal_) * normal_;
  return {along, v - along};
}

Vec3 PassivityControl::damper(const Vec3& way, const Vec3& change, double dt, const PortKnowledge& known) noexcept {
  Vec3 stride = way;
  if (known.velocity) {
    stride = *known.velocity * dt;
  } else if (o_.encoder_step > 0) {
    // One step of the encoder shall not count more than this share of the force.
    constexpr double kShare = 0.05;
    velocity_.put(x_, dt);
    const double most = damping_ > 0 ? damping_ : o_.most_damping;
    if (most > 0) stride = velocity_.velocity(kShare * force_.norm() / most) * dt;
  }
  const Axes ways = split(stride), changes = split(change);
  const double all = debt();
  damping_ = 0;
  Vec3 out = Vec3::Zero();
  for (std::size_t i = 0; i < (o_.axes_apart ? 2u : 1u); ++i) {
    double owed = std::max(debt_[i], -taken_);
    if (o_.axes_apart) {  // less than nothing taken from the hand is owed by both, as their debts are
      const double share = all > 0 ? debt_[i] / all : 0.5;
      owed = std::max(debt_[i], -share * taken_);
    }
    const double d = damping_for(owed, ways[i].squaredNorm(), changes[i].squaredNorm(), dt);
    damping_ = std::max(damping_, d);
    out += d * ways[i] / dt;
  }
  if (damping_ > 0) ++damped_ticks_;
  return out;
}

/// That dissipates the debt in one more tick like the last one; but no more than a few times what a spring as stiff
/// as the one just felt needs. An old debt paid in one tick in which the encoder moved by one step is a blow.
/// @param square  of the way of a tick [m^2]   @param change_square  of the spring's force meanwhile [N^2]
double PassivityControl::damping_for(double owed, double square, double change_square, double dt) noexcept {
  constexpr double kHaste = 2;
  if (o_.most_damping <= 0 || !(owed > 0) || !(square > 0)) return 0;
  const double felt = std::sqrt(change_square / square);
  return std::min({o_.most_damping, owed * dt / square, kHaste * felt * (0.5 * dt + forces_.delay())});
}

Vec3 TurnSum::add(const Quaternion& r) noexcept {
  if (before_) {
    Quaternion way = r * before_->conjugate();
    if (way.w() < 0) way.coeffs() = -way.coeffs();
    const double sine = way.vec().norm();
    // |v| = sin(a/2): for small angles a = 2 |v|, and no quotient of zeros.
    sum_ += sine > 0 ? Vec3(2 * std::atan2(sine, way.w()) / sine * way.vec()) : Vec3(Vec3::Zero());
  }
  before_ = r;
  return sum_;
}

}  // namespace kt
