#pragma once
// Builds everything from a scene and runs both rates: in lockstep (deterministic) or in two threads (wall clock).
#include <atomic>
#include <functional>
#include <vector>

#include "core/base/record.hpp"
#include "haptics/guard/safety_chain.hpp"
#include "haptics/machine/real_time_thread.hpp"
#include "haptics/options/band_powers.hpp"
#include "haptics/predict/predict.hpp"
#include "haptics/refresh/reducer_candidates.hpp"
#include "haptics/refresh/touch_parts.hpp"
#include "haptics/session/refresh_run.hpp"
#include "haptics/setup/built_scene.hpp"
#include "haptics/tick/local_simulation.hpp"
#include "haptics/touch/body_link.hpp"
#include "haptics/touch/touch.hpp"
#include "haptics/watch/lost_contact.hpp"
#include "self_contact/touching_model.hpp"

namespace kt {

/// The whole body at one moment, the local side's view laid over the global one: for pictures.
struct Snapshot {
  double t = 0;
  std::vector<Vec3> tools;  ///< reference points [m]
  VectorX x;                ///< [m], (3n)
};

/// Energy between the tool and a device that moves with the force, as passivity.hpp counts it.
struct PassivityRun {
  double least = 0;      ///< smallest sum that the hand had put in [J]; below 0: it was given energy
  double most = 0;       ///< largest such sum [J]
  double most_debt = 0;  ///< largest sum that holding the force gave away and nothing took back [J]
  double by_hold = 0;    ///< all that holding the force gave away [J]
  int damped_ticks = 0;  ///< in which the controller added damping
};

/// A device that somebody held.
struct DeviceRun {
  std::string name;            ///< in device.def
  DeviceInfo info;             ///< as the device told it
  double max_force = 0;        ///< that it was given at most [N], of the device and the scene
  Vec3 origin = Vec3::Zero();  ///< of the device's zero [m]
  SafetyCounts safety;
  GateReason gate = GateReason::open;       ///< at the end
  GateReason last_gate = GateReason::open;  ///< why it was shut last
  DelayEstimate delay;
  double coupling = 0;                  ///< [N/m] at the end; 0: none
  std::optional<PassivityRun> turning;  ///< of the torque, where the device gives one
  std::vector<std::string> notes{};     ///< of the device's driver
};

/// One tool in a run.
struct ToolRun {
  Pose start;                  ///< before the first tick
  Record<LocalFrame> frames;   ///< one a tick; their force is the one that was written to the device
  Record<Vec3> model_force;    ///< before passivity control and the device's limit: one a tick [N]
  Record<double> penetration;  ///< per tick, into the whole body [m]; empty when not asked for
  int limited_forces = 0;      ///< ticks whose force was cut to the device's limit
  int missed_impacts = 0;      ///< ticks without contact that should have had one: the sum of `lost`
  LostContact lost;
  double max_speed = 0;                   ///< bound of its speed that the patches were made for [m/s]
  std::optional<PassivityRun> passivity;  ///< of a device that moves with the force
  std::optional<DeviceRun> device;        ///< that somebody held
  Record<double> pose_age;                ///< of such a device at each tick [s]
};

/// The start and the place at the end of each tick [m].
std::vector<Vec3> places_of(const ToolRun& run);

/// The surface of a body without self-contact, through itself: where it was most deformed, and at the end.
struct SelfCrossing {
  int pairs = -1;          ///< of triangles, besides those that cross at the start; -1: not looked
  double t = 0;            ///< of the time with most [s]
  Vec3 at = Vec3::Zero();  ///< of one of them [m]
};

struct SessionResult {
  std::vector<ToolRun> tools = std::vector<ToolRun>(1);  ///< as many as the scene has
  Record<double> step_us;                                ///< CPU time of each tick [us]
  Record<double> lateness_us;                            ///< thread link: wall clock after the tick was due [us]
  RefreshRun refresh;                                    ///< what the refreshes took and found out
  std::string reducer, reducer_name, reducer_reason;     ///< in use at the end
  std::vector<ReducerCandidate> reducer_candidates;
  std::vector<ReducerChange> reducer_changes;
  std::vector<SettingChange> setting_changes;  ///< that were made while it ran
  double expected_force_error = std::numeric_limits<double>::quiet_NaN();
  double refresh_budget_ms = 0;  ///< infinity: none
  double certified_error = std::numeric_limits<double>::quiet_NaN();
  std::vector<RefreshEvent> refreshes;
  std::vector<Snapshot> snapshots;
  std::vector<Finding> findings;  ///< on the way: of the scene as it was built, of records, of a link. All that the run
                                  ///< shows besides: all_findings() in haptics/findings/
  int last_dof = 0, last_patch_vertices = 0;
  StepStatistics global_steps;                 ///< what the implicit steps took
  std::optional<SelfContactRun> self_contact;  ///< of a scene that asks for it
  SelfCrossing self_crossing;                  ///< of a scene that does not
  int deadline_misses = 0;                     ///< ticks whose compute time exceeded the haptic period
  long long allocations = -1;                  ///< in the haptic ticks; -1: not counted
  bool stopped = false;                        ///< by the stop flag, or where records found no room
  std::string records_full;                    ///< why the records end before the run should have; empty: they do not
  bool device_lost = false;                    ///< a device that somebody held did not come back for 10 s
  RealTimeGrant real_time{};                   ///< thread link: what the ticking thread was granted
  std::uint64_t hash = 0;                      ///< of every frame's position, force, mode and place, of all tools
};

class BodyFilm;  // haptics/session/body_film.hpp

/// Follows a run as it goes.
class SessionWatcher {
 public:
  virtual ~SessionWatcher() = default;
  /// Before the first tick; the touch is there until ended().
  virtual void begun(Touch& /*touch*/) {}
  /// A tick is over; in the thread that called run(), in two threads some milliseconds later.
  /// @param frames  of all tools, with the forces that were given to the devices
  virtual void ticked(std::span<const LocalFrame> /*frames*/, double /*step_us*/, long long /*allocations*/) {}
  /// As ModelObserver::refreshed: in two threads in the body's.
  virtual void refreshed(const RefreshRecord& /*record*/) {}
  virtual void ended() {}
};

struct SessionOptions {
  bool check_contacts = true;          ///< look for tools inside the body after each tick; in lockstep, also for
                                       ///< triangles that cross after each global step, with self-contact
  TouchReplay replay;                  ///< its schedule instead of the scene's; lockstep
  std::vector<ToolPath> tool_paths;    ///< replay: of each tool, instead of the scene's; the devices' limits stay
  std::vector<double> max_speeds;      ///< replay: the first run's bounds of the tools' speed [m/s]; 0: the device's
  std::vector<double> snapshot_times;  ///< [s]
  BodyFilm* film = nullptr;            ///< takes pictures of the body as it goes; borrowed
  std::function<long long()> count_allocations;  ///< allocations of this thread so far
  std::function<void(double)> progress;          ///< share done, 0..1
  const std::atomic<bool>* stop = nullptr;       ///< Ctrl-C: end after this tick and keep what is there
  SessionWatcher* watcher = nullptr;             ///< borrowed
  bool is_endless = false;                       ///< until it is stopped; the scene's duration is then what it took
  bool keeps_records = true;                     ///< else the result has no frames and no times of ticks
  const std::atomic<bool>* pause = nullptr;      ///< two threads: while true, no time passes
  std::shared_ptr<DeviceSlots> pushed;           ///< device pushed: poses from outside, forces to there
  LinkMaker link;                                ///< link.type network: the body's other end; none: replays only
  std::shared_ptr<MovedTarget> target;           ///< of the first tool, which a hand is to hold: moved from outside
};

/// What repeats a run in lockstep, whatever its clock and its user decided. Tools go the scene's way again: where a
/// device decided, tool_paths are to be added.
SessionOptions replay_of(const SessionResult& run);

/// A scene that can be run, as often as one likes: each time from its start on. Throws InputError.
class Session : public BuiltScene {
 public:
  explicit Session(const Scene& scene, SceneFiles files = {});  ///< as BuiltScene
  Session(const Scene& scene, Mesh body);                       ///< the scene with this mesh, in metres, for its own
  Session(const Scene& scene, std::unique_ptr<DeformableModel> model);  ///< with one's own model for its own
  SessionResult run(const SessionOptions& options = {});
  /// What is known to go wrong in a run, found at set-up.
  const std::vector<Prediction>& predictions() const { return predictions_; }

 private:
  std::vector<std::unique_ptr<HapticDevice>> devices(const SessionOptions& options) const;
  std::optional<BandPowers> followed_motion() const;
  double press_depth() const;
  std::vector<Prediction> predictions_;
};

}  // namespace kt
