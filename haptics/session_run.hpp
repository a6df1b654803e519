#pragma once
// What both ways of running a session share: the haptic tick with its bookkeeping.
#include "haptics/catch_up.hpp"
#include "haptics/refresher.hpp"
#include "haptics/session.hpp"
#include "haptics/tool_turn.hpp"

namespace kt {

/// The haptic side of one run: device, local simulation, records. One thread uses it.
class HapticLoop {
 public:
  HapticLoop(const Scene& scene, const ToolShape& tool, const SurfaceFriction& friction,
             std::unique_ptr<HapticDevice> device, const SessionOptions& options);

  /// One tick: device -> sweep -> local step -> device. Fills the next row of the records; nothing is allocated.
  LocalReport tick() noexcept;

  /// Steps a model that stands at the start of tick `at` towards the present, by `most` ticks at most, and moves `at`
  /// on. True when it has arrived. A model is adopted then, or as it is. No allocation.
  bool catch_up(std::unique_ptr<PreparedLocalModel>& model, int& at, int most) noexcept;

  /// The motion of the model in use, for the next one. No allocation.
  void record_motion(LocalMotion& out) const noexcept { kt::record_motion(local_->model(), tick_, out); }

  /// Gives the model that was in use back.
  std::unique_ptr<PreparedLocalModel> adopt(std::unique_ptr<PreparedLocalModel> model) noexcept;

  /// The body as the haptic side sees it: the global state with the local patch over it.
  Snapshot snapshot(const VectorX& global_x) const;

  int next_tick() const { return tick_; }
  int num_ticks() const { return static_cast<int>(frames_.size()); }
  const ToolShape& tool() const { return local_->tool(); }
  const Vec3& tool_position() const { return position_; }
  void finish(SessionResult& out);

 private:
  const SessionOptions& options_;
  std::unique_ptr<HapticDevice> device_;
  std::unique_ptr<HapticMethod> local_;
  CatchUp catch_up_;
  ToolTurn turn_;
  DeviceLimits limits_;
  Vec3 start_, position_;
  int tick_ = 0;
  std::vector<LocalFrame> frames_;
  std::vector<double> step_us_, penetration_;
  int limited_ = 0, missed_ = 0, last_dof_ = 0, last_vertices_ = 0;
  long long allocations_ = 0;
};

/// Everything a run needs, made from the session.
struct RunParts {
  const Scene& scene;
  const SurfaceFriction& friction;
  const SessionOptions& options;
  Refresher& refresher;
  HapticLoop& haptic;
  SessionResult& result;
  int ticks_per_refresh;
};

/// New local models are brought to the present before they are adopted; baselines know nothing of that.
bool catches_up(const Scene& scene);
/// For CatchUp; none when nothing catches up.
std::unique_ptr<ContactSolver> scene_solver(const Scene& scene, const SurfaceFriction& friction);

void run_lockstep(const RunParts& run);
void run_threads(const RunParts& run);

}  // namespace kt
