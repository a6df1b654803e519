#pragma once
// A soft block with a tool over it, made without a scene: what the tests of the haptic tick press on.
#include "haptics/tick/local_simulation.hpp"

namespace kt {

struct SoftBlockOptions {
  std::string mesh = "block.msh";  ///< in meshes/; a surface without tetrahedra gets one inner layer
  double layer = 0.008;            ///< thickness of that layer [m]
  double young = 1e4;              ///< [Pa]
  double clamped = 0.05;           ///< lowest share of the height that is held
  LocalScheme scheme = LocalScheme::implicit_euler;
  Metric metric = Metric::implicit;
  std::string reducer = "wall";
  int rings = 1;
  double reach = 1;  ///< of the patch [m]; 1: the whole surface
  double h = 1e-3;   ///< haptic step [s]
  double blend = 0;  ///< over which a new local model's force fades in [s]
};

/// A mass-spring body and the local models of it. Refers to itself: stays where it is made.
class SoftBlock {
 public:
  explicit SoftBlock(const SoftBlockOptions& options = {});
  SoftBlock(const SoftBlock&) = delete;
  /// A local model of the body at `state` around the surface point nearest to p.
  std::unique_ptr<PreparedLocalModel> local_model(const State& state, const Vec3& p, int frame = 0) const;
  std::unique_ptr<PreparedLocalModel> local_model(const Vec3& p) const;  ///< of the body at rest

  SoftBlockOptions options;
  std::unique_ptr<DeformableModel> model;
  Surface surface;
};

/// The haptic tick over a body at rest, a tool, and its path so far.
class Press {
 public:
  Press(const SoftBlock& body, const ToolShape& tool, const std::string& law, const Friction& friction,
        const Vec3& start);
  /// One tick to the given place, and turned by a rotation vector [rad].
  LocalFrame go_to(const Vec3& place, const Vec3& turn = Vec3::Zero());
  /// `ticks` ticks along a straight line; `visit(frame)` after each.
  template <class Visit>
  void move(const Vec3& place, int ticks, Visit visit) {
    const Vec3 from = tool_;
    for (int i = 1; i <= ticks; ++i) visit(go_to(from + static_cast<double>(i) / ticks * (place - from)));
  }
  LocalFrame move(const Vec3& place, int ticks);  ///< the last frame

  VectorX patch_positions() const;  ///< after the last tick [m], (3p)
  double penetration() const;       ///< by contact_check [m]
  const Vec3& tool() const { return tool_; }
  LocalSimulation& local() { return local_; }

 private:
  LocalSimulation local_;
  Vec3 tool_;
  Quaternion turn_ = Quaternion::Identity();
};

constexpr ToolShape kPointTool{ToolShape::Kind::point, 0};
constexpr ToolShape kSphereTool{ToolShape::Kind::sphere, 0.004};

}  // namespace kt
