#pragma once
// Shoots at a surface and compares what the engine reports with where the tools' centres go through it.
#include <span>
#include <string>
#include <vector>

#include "collision/broad/triangle_index.hpp"
#include "tests/support/collision_oracle.hpp"
#include "tests/support/shots.hpp"

namespace kt {

/// What became of a shot, or of many.
struct ShotCount {
  long shots = 0;
  long through = 0;  ///< the centre goes through a face from its front: the surface must stop it by then
  long hits = 0;     ///< the engine reports an impact
  long leaks = 0;    ///< goes through, and no impact was reported by the end of that tick
  long late = 0;     ///< an impact was reported in that tick, but after it went through
  long behind = 0;   ///< came through a face from behind before anything was reported: passes, by promise
  long inside = 0;   ///< reported at the start of a tick, a little behind a face: counts as on it, by promise
  long apart = 0;    ///< reported where the triangle is further away than rounding allows
  double gap = 0;    ///< largest gap at a hit, of what rounding allows
  void add(const ShotCount& other);
};

struct ShotResult {
  ShotCount count;
  CollisionQuery query;  ///< tick and triangle of a leak, a late or a wrong report
};

/// Ticks of all shots, one tick after the other, with the broad phase refitted to each.
/// @param index  built for the surface's triangles
std::vector<ShotResult> shoot(const SurfaceTicks& surface, std::span<const Shot> shots, TriangleIndex& index);

/// The same for several indexes, a row each: where the shots go through is found once.
std::vector<std::vector<ShotResult>> shoot(const SurfaceTicks& surface, std::span<const Shot> shots,
                                           std::span<TriangleIndex* const> indexes);

/// The query as C++ text, for the bug's own test.
std::string to_text(const CollisionQuery& q);

}  // namespace kt
