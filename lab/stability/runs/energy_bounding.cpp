#include "lab/stability/runs/energy_bounding.hpp"

#include <algorithm>
#include <cmath>

namespace kt {
namespace {

/// Of what is beyond the wanted force, let go in a tick whatever the way: the body may have moved away.
constexpr double kLetsGo = 0.02;

}  // namespace

EnergyBounding::EnergyBounding(double damping, double h, double delay) : stiffest_(damping / (0.5 * h + delay)) {}

Vec3 EnergyBounding::tick(const Vec3& x, const Vec3& wanted) noexcept {
  const Vec3 way = started_ ? Vec3(x - x_) : Vec3(Vec3::Zero());
  started_ = true;
  x_ = x;
  const Vec3 wanted_before = wanted_;
  wanted_ = wanted;
  const Vec3& axis = wanted.squaredNorm() > 0 ? wanted : force_;
  if (axis.squaredNorm() == 0) return force_;
  const Vec3 normal = axis.normalized();
  const double in = -way.dot(normal), was = force_.dot(normal), aim = wanted.dot(normal);
  const double most = stiffest_ * std::abs(in);
  double size = was;
  if (aim < was)
    size = std::max(aim, was - std::max(most, kLetsGo * (was - aim)));
  else if (in > 0)
    size = std::min(aim, was + most);
  else  // on the way back it falls as the body's does: one that stood would give more than was put in
    size = std::max(0.0, was - std::clamp(wanted_before.dot(normal) - aim, 0.0, most));
  const Vec3 across = force_ - was * normal;  // towards nothing: what is wanted is along the normal
  const double most_across = stiffest_ * (way + in * normal).norm() + kLetsGo * across.norm();
  const double left = across.norm();
  force_ = size * normal + (left > most_across ? Vec3((1 - most_across / left) * across) : Vec3(Vec3::Zero()));
  return force_;
}

}  // namespace kt
