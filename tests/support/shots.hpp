#pragma once
// Tools shot at a surface in ticks of 1 ms: at its faces, edges and vertices, while it rests, moves or deforms.
#include "collision/shape/contact.hpp"
#include "tests/support/random_sample.hpp"

namespace kt {

enum class SurfaceMotion { still, rigid, deforming };
enum class ShotTarget { face, edge, vertex };

/// A surface at the ends of successive ticks, straight in between.
struct SurfaceTicks {
  static constexpr int kTicks = 8;
  std::vector<Triangle> triangles;
  std::vector<VectorX> x;  ///< kTicks + 1 times
  SurfaceMotion motion = SurfaceMotion::still;
  MovingTriangles during(int tick) const { return {triangles, x[tick], x[tick + 1]}; }
};

/// Moves by up to 5 mm and 0.1 rad a tick, or every vertex at random by up to 1 mm.
SurfaceTicks random_ticks(Sample& s, const std::vector<Triangle>& triangles, const VectorX& x, SurfaceMotion motion);

/// A tool whose centre goes straight and evenly through a place of the surface.
struct Shot {
  ShotTarget target = ShotTarget::face;
  bool from_behind = false;  ///< of the triangle aimed at
  bool at_boundary = false;  ///< the centre, or the sphere's front, is there at the end of a tick exactly
  double speed = 0;          ///< relative to the surface [m/s]
  ToolShape tool;
  Vec3 place = Vec3::Zero(), way = Vec3::Zero();  ///< [m], [m] a tick
  double when = 0;                                ///< it is there [ticks]

  Vec3 centre(int tick) const { return place + (tick - when) * way; }
  ToolSweep sweep(int tick) const { return {centre(tick), centre(tick + 1)}; }
};

/// 0.1 to 50 m/s; points and spheres; head-on, from anywhere, or grazing; one in ten from behind.
Shot random_shot(Sample& s, const SurfaceTicks& surface);

}  // namespace kt
