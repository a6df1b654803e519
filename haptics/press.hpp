#pragma once
// A sphere pressed into a body in equilibrium, without friction: the force that model and mesh alone decide.
#include <functional>

#include "collision/contact.hpp"
#include "core/deformable_model.hpp"

namespace kt {

struct PressOptions {
  double stiffness = 0;  ///< [N/m], > 0: of every touching triangle; far above the body's, what is left is overlap
  int steps = 4;         ///< in which the tool goes its way, >= 1
  std::string solver = "automatic";
  std::function<bool()> stop;  ///< asked before every linear system; true: RunError
};

struct PressResult {
  State state;                ///< of the body at the end
  Vec3 force = Vec3::Zero();  ///< on the tool [N]
  double overlap = 0;         ///< largest of tool and body [m]
  int iterations = 0;         ///< of Newton's method
  bool converged = false;
};

/// The tool's centre goes from `from` to `to`; equilibrium at every step. Every triangle that the sphere reaches is
/// pushed at its closest point, along the line to the centre: as stiff springs, the limit is that nothing overlaps.
/// Throws RunError when a step has no solution or `stop` says so.
PressResult press(const DeformableModel& model, const State& start, double radius, const Vec3& from, const Vec3& to,
                  const PressOptions& options);

}  // namespace kt
