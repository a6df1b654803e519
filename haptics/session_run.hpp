#pragma once
// What both ways of running a session share: the haptic tick with its bookkeeping.
#include "haptics/body_check.hpp"
#include "haptics/catch_up.hpp"
#include "haptics/device/passivity.hpp"
#include "haptics/link/motion_record.hpp"
#include "haptics/refresher.hpp"
#include "haptics/session.hpp"
#include "haptics/tool_turn.hpp"

namespace kt {

/// The haptic side of one run: devices, local simulation, records. One thread uses it.
class HapticLoop {
 public:
  /// @param tools, devices  as many as the scene has tools
  /// @param surface         of the whole body, for the check of contacts
  /// @param check_later     the check takes none of this thread's time: look_at_past() makes it, in another one
  HapticLoop(const Scene& scene, std::span<const ToolShape> tools, const SurfaceFriction& friction,
             std::vector<std::unique_ptr<HapticDevice>> devices, const SessionOptions& options, const Surface& surface,
             bool check_later);

  /// One tick: devices -> sweeps -> local step -> devices. Fills the next row of the records; nothing is allocated.
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

  /// Checks up to `most` of the recorded ticks that this model was in use for, which is over. False: none is left.
  bool look_at_past(const PreparedLocalModel& model, int most);
  const PreparedLocalModel& model() const { return local_->model(); }

  int next_tick() const { return tick_; }
  int num_ticks() const { return static_cast<int>(step_us_.size()); }
  std::vector<Vec3> tool_positions() const;
  void finish(SessionResult& out);

 private:
  /// A tool with its device and its records.
  struct Hand {
    std::unique_ptr<HapticDevice> device;
    ToolShape shape;
    ToolTurn turn;
    DeviceLimits limits;
    Vec3 start, position;
    std::vector<LocalFrame> frames;
    std::vector<double> penetration;
    int limited = 0;
    LostContact lost;
    std::optional<PassivityControl> passivity;  // of a device that moves with the force
    std::optional<PassivityRun> energy() const;
  };
  ToolSweep sweep_of(const Hand& hand, int tick) const;
  void look(int tick, const VectorX& q);
  const SessionOptions& options_;
  std::vector<Hand> hands_;
  std::unique_ptr<HapticMethod> local_;
  CatchUp catch_up_;
  std::optional<BodyCheck> check_;
  std::unique_ptr<MotionRecord> record_;  // of ticks that are checked later
  VectorX past_q_;
  int past_frame_ = -1;
  int tick_ = 0;
  std::vector<double> step_us_;
  int last_dof_ = 0, last_vertices_ = 0;
  long long allocations_ = 0;
};

/// Everything a run needs, made from the session.
struct RunParts {
  const Scene& scene;
  std::span<const ToolShape> tools;
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

double process_time_ms();  ///< CPU time of all threads

void run_lockstep(const RunParts& run);
void run_threads(const RunParts& run);

}  // namespace kt
