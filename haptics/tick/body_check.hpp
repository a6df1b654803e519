#pragma once
// An independent look at the end of a tick: is a tool inside the whole body? The body is where it was when the local
// model in use was linearized, with the patch laid over it and the rest going with it as the apron does, as a picture
// would show it. Brute force outside the haptic tick's time, with none of its shortcuts. Of the model it reads what no
// tick changes.
#include <array>
#include <span>
#include <vector>

#include "collision/held/moving_tool.hpp"
#include "haptics/tick/prepared_local_model.hpp"

namespace kt {

class BodyCheck {
 public:
  /// Depths above this count as inside: far above the rounding of positions, far below what a hand or a picture shows.
  static constexpr double kInside = 1e-7;  // [m]

  /// @param surface  of the whole body; borrowed      @param tools  1 to kMaxTools
  BodyCheck(const Surface& surface, std::span<const ToolShape> tools);

  /// The local model in use from now on. Borrowed until the next one.
  void take(const PreparedLocalModel& model);
  /// Its coordinates after the tick that is looked at, then what the points of a fine patch have yielded by.
  void place(const VectorX& q);

  /// Depth of a tool's deepest point in the body [m]; 0: outside. A ball or a capsule touches refined cells at their
  /// nodes: what flat facets between these rise into it is none.
  double depth(int tool, const ToolSweep& sweep);
  /// A tool that touches nothing and ends outside, and was in the body on its way or went through it: past triangles
  /// that the local model does not have, or so far in one tick that its centre crosses the surface.
  bool went_through(int tool, const ToolSweep& sweep);
  /// A tool that touches something, but went so far in one tick that contact did not keep its centre outside.
  bool leapt_into(int tool, const ToolSweep& sweep, double depth) const;

 private:
  /// Triangles that can be the nearest ones to a tool as long as it stays within `slack` of `from`, all motion of the
  /// body since counted.
  struct Near {
    Vec3 from = Vec3::Zero();
    VectorX patch_x;    // then
    double slack = -1;  // [m]; below 0: not chosen yet
    SurfacePatch patch;
  };
  SurfacePatch& near(int tool, const Vec3& place);
  double moved_since(const Near& near) const;
  double between_nodes(const MovingTool& tool, const Vec3& place) const;
  const Surface& surface_;
  std::vector<MovingTool> tools_;
  std::vector<double> reach_;
  const PreparedLocalModel* model_ = nullptr;
  std::vector<int> refined_;       // facets of local_ that are
  VectorX patch_x_, local_x_, x_;  // of the patch's vertices, of its contact surface, of all vertices
  std::vector<Triangle> local_;    // of the patch's contact surface
  std::vector<Triangle> rest_;     // of the body, without the patch
  std::vector<int> rest_node_;     // of the vertices after local_x_
  std::array<Near, kMaxTools> near_;
};

}  // namespace kt
