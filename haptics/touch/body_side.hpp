#pragma once
// The slow half of a Touch: refreshes of the body, changes of settings, and what is told of it. One thread at a time
// refreshes; set(), status() and copy_positions() may be called from any other.
#include <functional>
#include <mutex>

#include "haptics/refresher.hpp"
#include "haptics/touch/body.hpp"
#include "haptics/touch/touch_status.hpp"

namespace kt {

class BodySide {
 public:
  /// @param body  borrowed
  BodySide(const Body& body, const TouchOptions& options);

  /// As Refresher::refresh, after the changes of settings that wait. Books its time and its event.
  /// @param other_ms  CPU time of the process that is not the refresh's, now
  std::unique_ptr<PreparedLocalModel> refresh(RefreshEvent event, std::span<const Pose> at,
                                              std::span<const LocalReport> reports, const LocalMotion* motion,
                                              const std::function<double()>& other_ms);

  /// A local model has been taken into use at this tick.
  void adopted(int linearized_tick, int tick);
  void failed(const std::string& why);

  /// From the next refresh on. Throws InputError for a setting that cannot be changed while the body is touched, or a
  /// value that is out of range; nothing is changed then.
  void set(const std::string& key, double value);
  void set(const std::string& key, const std::string& word);
  double number(const std::string& key) const;  ///< as it was set last
  std::string word(const std::string& key) const;

  TouchStatus status() const;
  /// The whole body as the last refresh had it [m], (3n).
  void copy_positions(VectorX& x) const;
  void copy_refresh(RefreshPicture& picture) const;

  Refresher& refresher() { return *refresher_; }
  const Refresher& refresher() const { return *refresher_; }
  const TouchOptions& options() const { return options_; }
  const State& state() const { return refresher_->state(); }
  const std::vector<SettingChange>& changes() const { return changes_; }
  std::vector<RefreshEvent> events;  ///< one a refresh
  std::vector<double> slow_cpu_ms;   ///< of each refresh, with its global step

 private:
  double delay(int tick) const;
  void apply_changes(int tick);
  void apply(const SettingChange& change);
  void renew_refresher();
  void show(const LocalModel& model, const LocalMotion* motion);
  const Body& body_;
  TouchOptions options_;
  SceneModel material_;
  std::shared_ptr<const SurfaceFriction> friction_;  // none: that of the start
  std::array<double, kMaxTools> radius_;             // of each tool; below 0: that of the start
  std::unique_ptr<DeformableModel> model_;           // none: the body's own
  std::unique_ptr<Refresher> refresher_;
  std::vector<SettingChange> changes_;  // that were made
  std::size_t next_replayed_ = 0;
  mutable std::mutex guard_;            // of what follows
  std::vector<SettingChange> waiting_;  // changes
  TouchOptions wanted_;                 // with those that wait
  SceneModel wanted_material_;
  TouchStatus status_;
  RefreshPicture picture_;
  VectorX x_;
};

}  // namespace kt
