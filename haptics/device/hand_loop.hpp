#pragma once
// The sampled loop of a hand that presses on a spring and damper: is it stable, and how stiff may the spring be?
//
// Colgate and Schenkel (1997): a wall K with damper B, sampled every h and held, is passive for whoever holds the
// device when the device damps by b > K h/2 + |B|. A delay T_d adds K T_d (Diolaiti, Niemeyer, Barbagli and Salisbury
// 2006 for small delays). Stability with one known hand needs less: where it ends is the spectral radius of the loop.
#include <limits>

namespace kt {

struct HandLoop {
  double wall_stiffness = 0, wall_damping = 0;                ///< K [N/m]; B [N s/m], of the sampled position
  double mass = 0.1, hand_stiffness = 300, hand_damping = 3;  ///< of hand and device together [kg], [N/m], [N s/m]
  double h = 1e-3, delay = 0;                                 ///< tick; until the force acts [s]
};

/// What stands between the wall and the device, and what it was told of the device, rightly or wrongly.
struct HandPort {
  double most_damping = 0;     ///< of passivity control [N s/m]; 0: none
  double coupling = 0;         ///< stiffness of a virtual coupling [N/m]; 0: none
  bool adapts = false;         ///< the coupling softens while the device swings
  double bounded_damping = 0;  ///< of energy bounding: what the device is said to damp [N s/m]; 0: none
  double delay = 0;            ///< that a force is said to take until it acts [s]
};

/// Stiffness that is felt through a coupling [N/m]: two springs in series.
inline double felt_stiffness(double wall, double coupling) {
  return coupling > 0 ? wall * coupling / (wall + coupling) : wall;
}

/// Damping of the device that makes the loop passive [N s/m].
inline double passive_damping(const HandLoop& loop) {
  return loop.wall_stiffness * (0.5 * loop.h + loop.delay) + loop.wall_damping;
}

/// Factor by which the loop's slowest motion shrinks (< 1) or grows (> 1) in one tick.
double loop_growth(const HandLoop& loop);

/// K at which the loop stops being stable [N/m], B growing with K from `loop` (its relaxation time B / K is kept; with
/// K = 0 it has none). 0: at no K; `most`: at none up to there.
double stiffest_stable_wall(const HandLoop& loop, double most = 1e7);

}  // namespace kt
