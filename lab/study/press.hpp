#pragma once
// A sphere pressed into a body at rest, without friction: the force that model and mesh alone decide. Hertz' problem on
// any body. What a point feels instead: docs/method.md#8-what-is-measured.
//
// The surface resists at points that are fixed in its triangles, each with a pressure in proportion to its overlap.
// That is the slope of an energy: Newton's method with a line search goes down it and does not swing between two
// places, as it does with the closest point of each triangle, which jumps.
#include <cmath>
#include <functional>

#include "core/body/deformable_model.hpp"

namespace kt {

/// Where a sphere is pressed in.
struct PressSite {
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();  ///< of its centre: where it touches, where it is held [m]
  double radius = 0;                            ///< [m], > 0

  double depth() const { return (to - from).norm(); }                    ///< [m]
  double contact_radius() const { return std::sqrt(radius * depth()); }  ///< by Hertz [m]
};

struct PressOptions {
  double young = 0;  ///< of the body, nearly [Pa], > 0: the points resist far more, so that they overlap by a per cent
                     ///< of the depth
  std::string solver = "automatic";  ///< core/linear/step_solvers.def
  std::function<bool()> stop = {};   ///< asked before every linear system; true: RunError
};

struct PressResult {
  State state;                ///< of the body at the end
  Vec3 force = Vec3::Zero();  ///< on the tool [N]
  double overlap = 0;         ///< largest of tool and body [m]
  double imbalance = 0;       ///< norm of the forces that are left on the free nodes / of the force on the tool
  int iterations = 0;         ///< linear systems
  bool settled = false;       ///< at rest, and the tool is pushed out: else the force is not to be used
};

/// Throws RunError when a step has no solution or `stop` says so.
PressResult press(const DeformableModel& model, const State& start, const PressSite& site, const PressOptions& options);

}  // namespace kt
