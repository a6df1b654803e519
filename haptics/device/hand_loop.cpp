#include "haptics/device/hand_loop.hpp"

#include <cmath>
#include <vector>

#include "core/linear/dense/dense_solvers.hpp"
#include "haptics/device/hand_motion.hpp"

namespace kt {
namespace {

/// One tick of the loop, linear in its state: y, v, y of the last tick, and the forces on their way, newest first.
class LinearLoop {
 public:
  explicit LinearLoop(const HandLoop& loop) : loop_(loop) {
    const double ticks = loop.delay / loop.h, whole = std::floor(ticks * (1 + 1e-12));
    const double late = std::max(0.0, ticks - whole) * loop.h;
    on_the_way_ = static_cast<int>(whole) + 1;  // beside the force of this tick
    before_ = {loop.mass, loop.hand_damping, loop.hand_stiffness, late};
    after_ = {loop.mass, loop.hand_damping, loop.hand_stiffness, loop.h - late};
  }
  int size() const { return 3 + on_the_way_; }

  VectorX tick(const VectorX& s) const {
    double y = s[0], v = s[1];
    VectorX forces(on_the_way_ + 1);
    forces << -loop_.wall_stiffness * y - loop_.wall_damping * (y - s[2]) / loop_.h, s.tail(on_the_way_);
    VectorX out(size());
    out[2] = y;
    before_.step(y, v, forces[on_the_way_]);
    after_.step(y, v, forces[on_the_way_ - 1]);
    out[0] = y;
    out[1] = v;
    out.tail(on_the_way_) = forces.head(on_the_way_);
    return out;
  }

 private:
  HandLoop loop_;
  int on_the_way_;
  HandMotion before_, after_;
};

}  // namespace

double loop_growth(const HandLoop& loop) {
  const LinearLoop one(loop);
  MatrixX step(one.size(), one.size());
  for (int i = 0; i < one.size(); ++i) step.col(i) = one.tick(VectorX::Unit(one.size(), i));
  return spectral_radius(step);
}

double stiffest_stable_wall(const HandLoop& loop, double most) {
  const double relaxation = loop.wall_stiffness > 0 ? loop.wall_damping / loop.wall_stiffness : 0;
  const auto is_stable = [&](double stiffness) {
    HandLoop at = loop;
    at.wall_stiffness = stiffness;
    at.wall_damping = relaxation * stiffness;
    return loop_growth(at) < 1;
  };
  // Not the last stable one but the end of the first stable stretch: a delayed loop can come back far above it.
  double low = 1e-3, high = low;
  if (!is_stable(low)) return 0;
  while (high < most && is_stable(high)) {
    low = high;
    high *= 1.25;
  }
  if (high >= most) return most;
  for (int i = 0; i < 30; ++i) {
    const double middle = std::sqrt(low * high);
    (is_stable(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace kt
