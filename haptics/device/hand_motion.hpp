#pragma once
// The exact motion of a hand over a time in which the force stands still: what a device does between two writes.
// A sampled loop gains its energy exactly there (Colgate and Schenkel 1997), so no scheme with damping of its own will
// do.
#include <cmath>

namespace kt {

/// y'' = -(stiffness y + damping y' - force) / mass over a fixed time: (y, y') at its end is affine in (y, y').
class HandMotion {
 public:
  HandMotion() = default;
  /// @param mass [kg], > 0   @param damping [N s/m], >= 0   @param stiffness [N/m], > 0   @param h [s], >= 0
  HandMotion(double mass, double damping, double stiffness, double h) : stiffness_(stiffness) {
    const double s = damping / (2 * mass), square = stiffness / mass;
    const double apart = s * s - square;  // of the two decay rates: half their difference, squared
    double c, si;                         // e^(-s h) cosh(r h) and e^(-s h) sinh(r h) / r; r imaginary: cos, sin
    if (apart < 0) {
      const double w = std::sqrt(-apart);
      c = std::exp(-s * h) * std::cos(w * h);
      si = std::exp(-s * h) * std::sin(w * h) / w;
    } else {
      // Not cosh and sinh: they overflow where damping is strong. And no difference of nearly equal rates.
      const double r = std::sqrt(apart), slow = std::exp(-square / (s + r) * h), quick = std::exp(-(s + r) * h);
      c = 0.5 * (slow + quick);
      si = 2 * r * h < 1e-4 ? h * std::exp(-s * h) : (slow - quick) / (2 * r);
    }
    yy_ = c + s * si;
    yv_ = si;
    vy_ = -square * si;
    vv_ = c - s * si;
  }

  /// Scalars or vectors: y [m], v [m/s], force [N].
  template <class T>
  void step(T& y, T& v, const T& force) const {
    const T away = y - force / stiffness_;  // from where spring and force balance
    y += (yy_ - 1) * away + yv_ * v;
    v = vy_ * away + vv_ * v;
  }

 private:
  double stiffness_ = 1, yy_ = 1, yv_ = 0, vy_ = 0, vv_ = 1;
};

}  // namespace kt
