#pragma once
// A tool over one step: where the corners of its core are at both ends. All memory is taken at construction.
#include <array>

#include "collision/impact/hull_impact.hpp"
#include "collision/shape/swept_box.hpp"
#include "collision/shape/tool_features.hpp"
#include "collision/shape/tool_shape.hpp"

namespace kt {

/// The core of a tool at rest in the world: what held contacts are looked for with. Borrowed views.
struct ToolCore {
  std::span<const Vec3> corners;              ///< [m]; of a point and a sphere: the reference point
  std::span<const std::array<int, 2>> edges;  ///< each once, by corner
  std::span<const Triangle> triangles;        ///< by corner
  const ToolFeatures* features = nullptr;     ///< those of all these that can be the first to touch
};

class MovingTool {
 public:
  explicit MovingTool(ToolShape shape);

  /// Takes the tool along `sweep`. No allocation.
  void move(const ToolSweep& sweep) noexcept;

  /// Of its rounding [m], from the next move on. No allocation.
  void set_radius(double radius) noexcept { shape_.radius = radius; }

  const ToolShape& shape() const noexcept { return shape_; }
  const ToolSweep& sweep() const noexcept { return sweep_; }
  bool is_round() const noexcept { return shape_.corners.empty(); }                         ///< a point or a sphere
  ToolCore core() const noexcept { return {x_t1_, edges_, shape_.triangles, &features_}; }  ///< at the end of the step
  std::span<const Vec3> corners_t0() const noexcept { return x_t0_; }                       ///< at its start
  /// Way of the point of the tool that is at `x` at the end of the step, during the step [m].
  Vec3 way(const Vec3& x) const noexcept {
    if (angle_ == 0) return sweep_.x_t1 - sweep_.x_t0;
    return x - sweep_.x_t0 - back_ * (x - sweep_.x_t1);
  }
  /// Encloses the core in the whole step, and how far its points get off straight lines.
  const Box& box() const noexcept { return box_; }

  /// The convex pieces of a capsule or a mesh.
  int num_hulls() const noexcept { return static_cast<int>(hulls_.size()); }
  MovingHull hull(int i) const noexcept;
  const Box& hull_box(int i) const noexcept { return hull_box_[i]; }  ///< as box(), of one piece

 private:
  struct Piece {
    Triangle corner{};
    int corners = 0;
    double arm = 0;  // of the corner that is farthest from the reference point [m]
  };
  ToolShape shape_;
  ToolSweep sweep_;
  Mat3 back_ = Mat3::Identity();  // from the tool's turn at the end to that at the start
  std::vector<Piece> hulls_;
  std::vector<std::array<int, 2>> edges_;
  ToolFeatures features_;
  std::vector<Vec3> x_t0_, x_t1_;
  std::vector<Box> hull_box_;
  Box box_{};
  double angle_ = 0;  // that the tool turns by [rad]
};

/// The part of the sweep after the share `toi` of it.
ToolSweep rest_of(const ToolSweep& sweep, double toi) noexcept;

}  // namespace kt
