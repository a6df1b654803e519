#pragma once
// A ball pressed into a block whose cells are refined under it, through the whole engine.
#include <array>
#include <cmath>
#include <string>

#include "core/body/mesh.hpp"
#include "haptics/session/session.hpp"

namespace kt {

inline constexpr double kBallRadius = 0.008, kBlockWide = 0.06, kBlockThick = 0.02;

struct BlockPress {
  double cell = 0.005, depth = 0.0015;
  double x = 0, y = 0;  // from the middle, in cells
  double speed = 0, mu = 0;
  double duration = 0.5;
  double fineness = 1.4;
  int nodes = 900;
  double latency_ms = 0, press_time = 0.3;
  std::string refine = "follow", type = "fem", element = "tet4", link = "lockstep";
};

/// A block of 10 kPa, bonded below, and a ball of 8 mm.
inline Scene scene_of(const BlockPress& p) {
  Scene s = default_scene();
  s.object.mesh = "block";
  s.object.model.type = p.type;
  s.object.model.element = p.element;
  s.object.model.material = "linear";
  s.object.fixed.below = FixedBelow{"z", 1e-6};
  s.tool.radius = kBallRadius;
  s.tool.path.press_drag = PressDrag{.at = std::array{0.5 * kBlockWide + p.x * p.cell, 0.5 * kBlockWide + p.y * p.cell},
                                     .depth = p.depth,
                                     .press_time = p.press_time,
                                     .direction = {1, 0.3, 0},
                                     .speed = p.speed};
  s.duration = p.duration;
  s.contact.mu_static = s.contact.mu_kinetic = p.mu;
  s.contact.surface = "flat";
  s.local.refine = p.refine;
  s.local.fineness = p.fineness;
  s.local.refine_nodes = p.nodes;
  s.link.latency_ms = p.latency_ms;
  s.local.reducer = "condensed";
  s.link.type = p.link;
  s.collision.backend = "brute_force";
  return s;
}

inline Mesh block_of(const BlockPress& p) {
  const int wide = static_cast<int>(std::lround(kBlockWide / p.cell));
  return kuhn_block(wide, wide, static_cast<int>(std::lround(kBlockThick / p.cell)), p.cell);
}

inline SessionResult run(const BlockPress& p) { return Session(scene_of(p), block_of(p)).run(); }

}  // namespace kt
