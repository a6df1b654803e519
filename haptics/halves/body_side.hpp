#pragma once
// The slow half of a Touch: refreshes of the body, changes of settings, and what is told of it. One thread at a time
// refreshes; set(), status() and copy_positions() may be called from any other.
#include <atomic>
#include <deque>
#include <functional>
#include <mutex>

#include "haptics/body/body.hpp"
#include "haptics/halves/model_observer.hpp"
#include "haptics/halves/swap_energy.hpp"
#include "haptics/halves/touch_moment.hpp"
#include "haptics/halves/touch_status.hpp"
#include "haptics/refresh/refresher.hpp"

namespace kt {

/// What touching a body of a lattice does not go with, one line with the cure; empty: nothing.
std::string why_no_lattice(const TouchOptions& options);

class BodySide {
 public:
  /// @param body  borrowed
  /// @param from  as check_state() gives it; null: the body's start
  BodySide(const Body& body, const TouchOptions& options, const TouchState* from = nullptr);

  /// As Refresher::refresh, after the changes of settings that wait. Books its time and its event.
  /// @param other_ms  CPU time of the process that is not the refresh's, now
  std::unique_ptr<PreparedLocalModel> refresh(RefreshEvent event, std::span<const Pose> at,
                                              std::span<const LocalReport> reports, const LocalMotion* motion,
                                              const std::function<double()>& other_ms,
                                              const std::function<void()>& when_reduced = {});
  /// The model of the last refresh, which waits for it (when_reduced), goes on from a later motion.
  void start(const LocalMotion& motion, std::span<const LocalReport> reports, PreparedLocalModel& model);

  /// How long local models are on their way [s], where that is measured, as over a network: for the refreshes from the
  /// next one on; none: as the settings have it. A replay repeats a run when it is told what the run's records say
  /// (RefreshRecord::delay). In the thread that refreshes.
  void expect(std::optional<double> delay) { told_delay_ = delay; }

  /// A local model has been taken into use at this tick.
  /// @param old  that was in use until then; null: it was the first, or is on another computer
  void adopted(int linearized_tick, int tick, const PreparedLocalModel* old);
  void failed(const std::string& why);

  /// From the next refresh on; of a setting that is changed more than once until then, the last value counts. Throws
  /// InputError for a setting that cannot be changed while the body is touched, or a value that is out of range;
  /// nothing is changed then.
  void set(const std::string& key, double value);
  void set(const std::string& key, const std::string& word);
  /// Changes that no refresh has taken yet.
  std::vector<SettingChange> waiting() const;
  double number(const std::string& key) const;  ///< as it was set last
  std::string word(const std::string& key) const;
  /// Ticks from a refresh to the next, where `planned` were planned: fewer when a higher rate has been set since. In
  /// the thread that refreshes.
  int interval(int planned) const;

  TouchStatus status() const;
  /// The whole body as the last refresh had it [m], (3n).
  void copy_positions(VectorX& x) const;
  /// That with its velocities, and what was known then for the next refreshes: without tools.
  void copy_state(TouchState& state, RefreshMemory& memory) const;
  void copy_refresh(RefreshPicture& picture) const;

  Refresher& refresher() { return *refresher_; }
  const Refresher& refresher() const { return *refresher_; }
  const Body& body() const { return body_; }
  const TouchOptions& options() const { return options_; }
  const State& state() const { return refresher_->state(); }
  /// Is told of each refresh; none: nobody. Before the first one.
  void observe(ModelObserver* observer) { observer_ = observer; }
  /// The last refresh goes on its way by another schedule than it was begun with.
  void reschedule(const RefreshEvent& event) { open_.back().event = event; }
  /// CPU time of the last refresh with its global step, less what another core did meanwhile.
  double last_cpu_ms() const { return open_.back().cpu_ms - open_.back().beside_ms; }
  /// No refresh comes any more: the observer is told of those that it does not know yet.
  void finish();

 private:
  /// TouchStatus::force_factor, of this local model.
  double force_factor(const LocalModel& model) const;
  double delay(int tick) const;
  void keep_last(const SettingChange& change);
  void apply_changes(int tick);
  void apply(const std::vector<SettingChange>& changes);
  void tell_of_settled();
  void renew_refresher();
  void show(const LocalModel& model, const LocalMotion* motion);
  const Body& body_;
  TouchOptions options_;
  SceneModel material_;
  std::shared_ptr<const SurfaceFriction> friction_;  // none: that of the start
  std::array<double, kMaxTools> radius_;             // of each tool; below 0: that of the start
  std::unique_ptr<DeformableModel> model_;           // none: the body's own
  std::unique_ptr<Refresher> refresher_;
  std::shared_ptr<const TouchMoment> moment_;  // that the first refresh goes on from; null: none
  ModelObserver* observer_ = nullptr;
  std::optional<double> told_delay_;    // [s]
  std::deque<RefreshRecord> open_;      // of which it is not told yet: their models are on their way
  std::vector<SettingChange> applied_;  // since the last refresh
  int overtaken_ = -1;                  // models linearized up to that tick will not be adopted any more
  int num_refreshes_ = 0, last_tick_ = 0;
  std::size_t next_replayed_ = 0;
  std::atomic<double> wanted_rate_hz_;  // of refreshes, as it was set last
  mutable std::mutex guard_;            // of what follows
  SwapEnergy swaps_;
  std::vector<SettingChange> waiting_;  // changes
  TouchOptions wanted_;                 // with those that wait
  SceneModel wanted_material_;
  TouchStatus status_;
  RefreshPicture picture_;
  State shown_;           // of the last refresh
  RefreshMemory memory_;  // of it
};

/// With what is clamped, and what goes with the cells of a lattice, in its place. Throws InputError for a state that is
/// not one of this body, or not finite.
TouchState check_state(const Body& body, TouchState state);

}  // namespace kt
