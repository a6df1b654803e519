#pragma once
// The 1 kHz half of a Touch: poses in, forces and a report for the body's half out. One thread at a time uses it.
#include "haptics/halves/pose_history.hpp"
#include "haptics/refresh/touch_parts.hpp"
#include "haptics/tick/catch_up.hpp"
#include "haptics/tick/local_report.hpp"

namespace kt {

/// Finite, no farther than places of a scene, and a rotation.
bool is_usable(const Pose& pose) noexcept;

class HapticSide {
 public:
  HapticSide(const TouchOptions& options, const SurfaceFriction& friction);

  /// Where the tools are before the first tick.
  void place(std::span<const Pose> tools) noexcept;

  /// Before the first tick: forces of tools in contact go on from those of another run [N]; none: they begin with none.
  void go_on_from(std::span<const std::optional<Vec3>> forces) noexcept { local_->go_on_from(forces); }

  /// One tick with the tools going to these poses; a frame for each, and what the body's half is to be told. Without a
  /// local model nothing is touched. No allocation, lock or clock.
  const LocalReport& tick(std::span<const Pose> tools, std::span<LocalFrame> frames) noexcept;

  /// Steps a model that stands at the start of tick `at` towards the present, by `most` ticks at most, and moves `at`
  /// on. True when it has arrived. A model is adopted then, or as it is. No allocation.
  bool catch_up(std::unique_ptr<PreparedLocalModel>& model, int& at, int most) noexcept;

  /// The motion of the model in use, for the next one. No allocation.
  void record_motion(LocalMotion& out) const noexcept { kt::record_motion(local_->model(), tick_, out); }

  /// Gives the model that was in use back.
  std::unique_ptr<PreparedLocalModel> adopt(std::unique_ptr<PreparedLocalModel> model) noexcept;

  bool has_model() const noexcept { return has_model_; }
  const PreparedLocalModel& model() const noexcept { return local_->model(); }
  int model_tick() const noexcept { return model_tick_; }      ///< that the model in use was linearized at
  int adopted_tick() const noexcept { return adopted_tick_; }  ///< since when it is in use
  /// Nodes of the local model where they are now, over those of the whole body.
  void lay_patch_over(VectorX& x) const;

  const LocalReport& report() const noexcept { return report_; }  ///< of the last tick
  /// Of so many ticks before that one, or as many as there were: poses alone.
  LocalReport past_report(int ticks) const noexcept;
  std::span<const TickContact> samples() const noexcept { return report_.contacts(); }

  int next_tick() const noexcept { return tick_; }
  double h() const noexcept { return local_->h(); }
  std::size_t num_tools() const noexcept { return poses_.size(); }
  std::span<const Pose> poses() const noexcept { return poses_; }
  /// Of the tick that was done last.
  ToolSweep last_sweep(std::size_t tool) const noexcept { return history_.sweep(tick_ - 1, tool); }

 private:
  std::unique_ptr<HapticMethod> local_;
  CatchUp catch_up_;
  std::vector<Pose> poses_;
  PoseHistory history_;
  LocalReport report_;
  bool has_model_ = false;
  int tick_ = 0, model_tick_ = 0, adopted_tick_ = 0;
};

}  // namespace kt
