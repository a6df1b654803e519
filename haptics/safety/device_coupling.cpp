#include "haptics/safety/device_coupling.hpp"

#include <algorithm>
#include <cmath>

namespace kt {

double coupling_stiffness(double device_damping, double nominal, double h, double delay) noexcept {
  double out = nominal > 0 ? nominal : kUnknownStiffness;
  if (device_damping > 0) {
    const double passive = kCouplingShare * device_damping / (0.5 * h + delay);
    out = nominal > 0 ? std::min(out, passive) : passive;
  }
  return out;
}

void DeviceCoupling::Felt::add(const Vec3& step, const Vec3& df) noexcept {
  constexpr double kKeeps = 0.9;
  constexpr double kLeast = 1e-7;  // [m] below it the force changes for other reasons
  if (step.squaredNorm() < kLeast * kLeast) return;
  work = kKeeps * work - df.dot(step);
  square = kKeeps * square + step.squaredNorm();
}

DeviceCoupling::DeviceCoupling(const CouplingOptions& o) : o_(o), k_(o.stiffness), goal_(o.stiffness) {}

Vec3 DeviceCoupling::tool(const Vec3& x, double dt) noexcept {
  constexpr double kMargin = 1.5;    // on the stiffness felt
  constexpr double kCreep = 0.1;     // [m/s] that the coupling may always stretch by
  constexpr double kStiffest = 1e4;  // body / coupling
  const Vec3 way = started_ ? Vec3(x - x_) : Vec3(Vec3::Zero());
  const Vec3 before = started_ ? tool_ : x;
  started_ = true;
  x_ = x;
  if (k_ > 0) adapt(dt);
  const Vec3 to = x - before;
  // Out of contact and not on the way back in: the tool is the device.
  if (!(k_ > 0) || (!touches_ && (felt_normal_.square == 0 || to.dot(normal_) >= 0))) {
    tool_ = x;
    step_ = tool_ - before;
    e_.setZero();
    e_rate_.setZero();
    felt_normal_ = felt_tangent_ = {};
    return tool_;
  }
  const double g = k_ + o_.damping / dt;
  const Vec3 pull = k_ * to + o_.damping / dt * way + body_;
  const Vec3 pull_normal = along(pull);
  const double most = kStiffest * k_;
  const double stiff_normal = std::min(kMargin * felt_normal_.stiffness(), most);
  const double stiff_tangent = std::min(kMargin * felt_tangent_.stiffness(), most);
  const Vec3 tool = before + pull_normal / (g + stiff_normal) + (pull - pull_normal) / (g + stiff_tangent);
  // It stretches no faster than device and body can move apart.
  const Vec3 e = tool - x;
  Vec3 stretched = e - e_;
  const double limit = kCreep * dt + 2 * way.norm();
  if (const double size = stretched.norm(); size > limit) stretched *= limit / size;
  e_rate_ = stretched / dt;
  e_ += stretched;
  tool_ = x + e_;
  step_ = tool_ - before;
  return tool_;
}

Vec3 DeviceCoupling::force(const Vec3& body_force, const Vec3& normal) noexcept {
  if (!(k_ > 0)) return body_force;
  const Vec3 df = body_force - body_;
  touches_ = body_force.squaredNorm() > 0;
  if (touches_) {
    normal_ = normal.squaredNorm() > 0 ? normal : Vec3(body_force.normalized());
    const Vec3 step_normal = along(step_);
    felt_normal_.add(step_normal, df);
    felt_tangent_.add(step_ - step_normal, df);
  }
  body_ = body_force;
  return touches_ ? Vec3(k_ * e_ + o_.damping * e_rate_) : Vec3(Vec3::Zero());
}

/// Half as stiff, over a while, when the device swings on in contact; back by 10 % a second out of contact: a spring
/// that is made stiffer while it is stretched gives energy, and would only begin to swing again.
void DeviceCoupling::adapt(double dt) noexcept {
  constexpr double kBack = 0.1;      // [1/s]
  constexpr double kSoftens = 0.02;  // [s] in which it is halved
  constexpr double kSoftest = 1.0 / 64;
  constexpr double kAway = 0.15;  // [s] longer than that is not a bounce
  if (!o_.adapts) return;
  away_ = touches_ ? 0 : away_ + dt;
  if (away_ > kAway)
    swing_.reset();
  else if (swing_.add(x_.dot(normal_), dt) && goal_ > kSoftest * o_.stiffness) {
    goal_ = 0.5 * k_;
    ++halvings_;
  }
  if (k_ > goal_)
    k_ = std::max(goal_, k_ * std::exp2(-dt / kSoftens));
  else if (away_ > kAway)
    goal_ = k_ = std::min(o_.stiffness, k_ * (1 + kBack * dt));
}

}  // namespace kt
