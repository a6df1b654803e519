#pragma once
// Builds everything from a scene and runs both rates: in lockstep (deterministic) or in two threads (wall clock).
#include <atomic>
#include <functional>
#include <vector>

#include "haptics/device/haptic_device.hpp"
#include "haptics/inverted_tetrahedra.hpp"
#include "haptics/local_simulation.hpp"
#include "haptics/predict.hpp"
#include "haptics/reducer_choice.hpp"
#include "io/scene.hpp"
#include "self_contact/touching_model.hpp"

namespace kt {

/// One refresh: which tick the body was linearized at, and which tick started with the new local model (-1: lost),
/// and the start of which tick the new local model was replayed from.
struct RefreshEvent {
  int linearized_tick = 0, adopted_tick = 0, started_tick = linearized_tick;
  bool operator==(const RefreshEvent&) const = default;
};

/// The whole body at one moment, the local side's view laid over the global one: for pictures.
struct Snapshot {
  double t = 0;
  Vec3 tool = Vec3::Zero();
  VectorX x;                          ///< [m], (3n)
  std::optional<Vec3> second_tool{};  ///< of a scene that has one
};

/// The body's contacts with itself, over the refreshes of a run.
struct SelfContactRun {
  SelfContactReport extremes;  ///< most contacts, nearest pair, largest sum of normal forces, most energy
  double mean_normal = 0;      ///< of the sums of normal forces [N]
  double touching_share = 0;   ///< of the global steps, those that end with a contact [-]
  double reach = 0;            ///< in use [m]
  double stiffness = 0;        ///< of the barrier, in use [N/m]
  int crossings = -1;  ///< most pairs of triangles that crossed after a global step: 0, or a bug; -1: not looked
};

/// Energy between the tool and a device that moves with the force, as passivity.hpp counts it.
struct PassivityRun {
  double least = 0;      ///< smallest sum that the hand had put in [J]; below 0: it was given energy
  double most = 0;       ///< largest such sum [J]
  double most_debt = 0;  ///< largest sum that holding the force gave away and nothing took back [J]
  double by_hold = 0;    ///< all that holding the force gave away [J]
  int damped_ticks = 0;  ///< in which the controller added damping
};

/// Where contact should have been in a run and was not, by the check of the whole body; see body_check.hpp.
struct LostContact {
  /// A tick in which the tool went through the body, or a part of it, and touched nothing; or so far in one tick that
  /// what it touched did not keep it outside.
  struct PassThrough {
    int tick = 0;         ///< its index
    double distance = 0;  ///< way of the tool in it [m]
  };
  int free_ticks_inside = 0;                ///< ticks without contact that end with the tool inside the body
  int pass_throughs = 0;                    ///< ticks in which it went through
  std::vector<PassThrough> went_through{};  ///< the first of these, at most kMostNamed
  int unchecked_ticks = 0;                  ///< in threads: that the record had no room for
  static constexpr std::size_t kMostNamed = 100;
};

/// A second tool in a run: as the fields of the same name in SessionResult are of the first one.
struct SecondToolRun {
  Vec3 start = Vec3::Zero();
  std::vector<LocalFrame> frames;
  std::vector<Vec3> model_force;
  std::vector<double> penetration;
  int limited_forces = 0, missed_impacts = 0;
  LostContact lost;
  double max_speed = 0;
  std::optional<PassivityRun> passivity;
};

struct SessionResult {
  Vec3 start = Vec3::Zero();                 ///< tool position before the first tick [m]
  std::vector<LocalFrame> frames;            ///< one a tick; their force is the one that was written to the device
  std::vector<Vec3> model_force;             ///< before passivity control and the device's limit: one a tick [N]
  std::vector<double> step_us;               ///< CPU time of each tick [us]
  std::vector<double> lateness_us;           ///< thread link: wall clock after the tick was due [us]
  std::vector<double> penetration;           ///< per tick, into the whole body [m]; empty when not asked for
  std::optional<SecondToolRun> second_tool;  ///< of a scene that has one
  std::vector<double> global_ms, refresh_ms;
  std::vector<double> slow_cpu_ms;  ///< CPU time of all threads but the haptic one for each refresh, with global steps
  std::vector<std::pair<std::string, std::vector<double>>> refresh_parts_ms;
  std::string reducer, reducer_name, reducer_reason;  ///< in use at the end
  std::vector<ReducerCandidate> reducer_candidates;
  std::vector<ReducerChange> reducer_changes;
  double expected_force_error = std::numeric_limits<double>::quiet_NaN();
  double refresh_budget_ms = 0;  ///< infinity: none
  double certified_error = std::numeric_limits<double>::quiet_NaN();
  double damping_coupling = 0;              ///< of the last local model
  int exact_steps = 0;                      ///< local models that were stepped exactly
  std::vector<double> linearization_error;  ///< of each refresh interval that ended in contact
  std::vector<RefreshEvent> refreshes;
  std::vector<Snapshot> snapshots;
  InvertedTetrahedra inverted;
  std::vector<std::string> warnings;
  std::vector<std::string> notes;  ///< those of the warnings that say nothing against the forces
  int last_dof = 0, last_patch_vertices = 0;
  StepStatistics global_steps;                 ///< what the implicit steps took
  std::optional<SelfContactRun> self_contact;  ///< of a scene that asks for it
  int definite_tangents = 0;                   ///< refreshes whose exact tangent was indefinite
  int looked_ahead = 0;                        ///< refreshes that linearized the body where it was expected to be
  int limited_forces = 0;                      ///< ticks whose force was cut to the device's limit
  std::optional<PassivityRun> passivity;       ///< of a device that moves with the force
  int missed_impacts = 0;                      ///< ticks without contact that should have had one: the sum of `lost`
  LostContact lost;
  int deadline_misses = 0;            ///< ticks whose compute time exceeded the haptic period
  long long allocations = -1;         ///< in the haptic ticks; -1: not counted
  bool stopped = false;               ///< by the stop flag
  bool real_time_scheduling = false;  ///< thread link: SCHED_FIFO was granted
  double max_speed = 0;               ///< bound of the tool's speed that the patches were made for [m/s]
  std::uint64_t hash = 0;             ///< of every frame's position, force, mode and place, of all tools
};

struct SessionOptions {
  bool check_contacts = true;           ///< look for tools inside the body after each tick; in lockstep, also for
                                        ///< triangles that cross after each global step, with self-contact
  std::vector<RefreshEvent> refreshes;  ///< replay: this schedule instead of the scene's; lockstep
  std::optional<std::vector<ReducerChange>> reducer_changes;  ///< replay: of "auto", and no others
  std::vector<std::vector<TimedPoint>> tool_paths;  ///< replay: of each tool, instead of the scene's; the devices'
                                                    ///< limits stay
  double max_speed = 0;                             ///< replay: the first run's tool speed bound [m/s]; 0: the device's
  double second_max_speed = 0;                      ///< the same of a second tool
  std::vector<double> snapshot_times;               ///< [s]
  std::function<long long()> count_allocations;     ///< allocations of this thread so far
  std::function<void(double)> progress;             ///< share done, 0..1
  const std::atomic<bool>* stop = nullptr;          ///< Ctrl-C: end after this tick and keep what is there
};

/// Everything of a scene that takes time to build: mesh, model, surface, device. Throws InputError.
class Session {
 public:
  explicit Session(const Scene& scene);
  Session(const Scene& scene, Mesh body);  ///< the scene with this mesh, in metres, for its own
  ~Session();
  SessionResult run(const SessionOptions& options = {});
  /// The same body from its start on, along another path: until the time of its last point.
  void follow(std::vector<TimedPoint> path);

  const Scene& scene() const { return scene_; }
  const DeformableModel& model() const { return *model_; }
  const Surface& surface() const { return surface_; }
  double mesh_unit() const { return mesh_unit_; }  ///< of the mesh file [m]; 1 for a mesh that is given in metres
  const ToolShape& tool() const { return tools_[0]; }
  std::span<const ToolShape> tools() const { return tools_; }  ///< 1 or 2
  const SurfaceFriction& friction() const { return friction_; }
  const State& start() const { return start_; }
  const std::vector<TimedPoint>& path() const { return path_; }  ///< of the first tool; of a hand its target
  /// What is known to go wrong in a run, found at set-up; each is a warning of the run's result too.
  const std::vector<Prediction>& predictions() const { return predictions_; }

 private:
  void build(Mesh mesh);
  void set_up_self_contact();
  std::optional<BandPowers> followed_motion() const;
  Scene scene_;
  std::unique_ptr<DeformableModel> model_;
  std::unique_ptr<SelfContact> self_contact_;  // none: the body passes through itself
  Surface surface_;
  SurfaceFriction friction_;
  State start_;  // at rest, hanging in its weight
  std::vector<ToolShape> tools_;
  std::vector<TimedPoint> path_, second_path_;
  std::vector<std::string> warnings_, notes_;
  std::vector<Prediction> predictions_;
  double mesh_unit_ = 1;
};

/// Loads, scales and, where the model needs it, repairs and tetrahedralizes the scene's mesh. What was not taken over
/// as it stands is appended to `notes`.
/// @param unit  of the file [m]
Mesh load_scene_mesh(const Scene& scene, std::vector<std::string>& notes, double* unit = nullptr);

/// Nodes that the scene clamps, ascending. Throws InputError when a choice holds no node or all of them.
std::vector<int> find_fixed_nodes(const Mesh& mesh, const SceneFixed& fixed);

}  // namespace kt
