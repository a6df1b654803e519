#pragma once
// The engine: a body that tools touch, one call a haptic tick. Scene files, devices, records and commands are made on
// top of it (session/), and so is a loop of one's own: docs/embedding.md.
#include <atomic>
#include <mutex>

#include "haptics/link/mailbox.hpp"
#include "haptics/touch/body_link.hpp"

namespace kt {

/// One thread at a time ticks. Without start() the body is refreshed inside some of the ticks, deterministic: the same
/// poses give the same bits, and a refresh takes its tens of milliseconds. After start() the body has its own thread,
/// and a tick never waits for it.
class Touch {
 public:
  /// Throws InputError for settings that are wrong or do not go together.
  /// @param body  borrowed: it has to stay where it is
  explicit Touch(const Body& body, TouchOptions options = {});
  ~Touch();
  Touch(const Touch&) = delete;
  Touch& operator=(const Touch&) = delete;

  /// Where the tools are before the first tick; without it, where the first tick has them.
  void place(std::span<const Pose> tools);
  void place(const Pose& tool) { place({&tool, 1}); }

  /// The body from now on in a thread of its own. Before the first tick; throws what its first refresh throws.
  void start();
  /// Ends that thread; ticks go on with the last local model. Throws what ended the body's simulation before.
  void stop();

  /// One haptic tick: the tools have come to these poses, world frame, each the same tool in every tick. A frame for
  /// each, which is there until the next tick. Forces are finite: a pose that is not leaves the tool where it was, and
  /// LocalFrame::flags says so. After start(): no allocation, lock or clock.
  std::span<const LocalFrame> tick(std::span<const Pose> tools) noexcept;
  const LocalFrame& tick(const Pose& tool) noexcept { return tick(std::span(&tool, 1))[0]; }

  /// The same for a loop that does not keep the rate: `dt` [s] have passed since the last call, in which the tools came
  /// here evenly. As many steps of 1 / local.rate_hz as fit are done, also none; more than kMostSteps are left out
  /// (kLateTick).
  std::span<const LocalFrame> tick(std::span<const Pose> tools, double dt) noexcept;
  const LocalFrame& tick(const Pose& tool, double dt) noexcept { return tick(std::span(&tool, 1), dt)[0]; }
  static constexpr int kMostSteps = 20;

  /// What tick() would do first: without start(), the refresh that is due. To take its time apart from the tick's.
  void refresh_if_due() noexcept;

  /// A setting, while the body is touched: live_settings(). From the next refresh on, booked in changes(). From any
  /// thread. Throws InputError: what, value, allowed range; nothing is changed then.
  void set(const std::string& key, double value) { side_->set(key, value); }
  void set(const std::string& key, const std::string& word) { side_->set(key, word); }
  double number(const std::string& key) const { return side_->number(key); }
  std::string word(const std::string& key) const { return side_->word(key); }

  /// Where the whole body is, for drawing: as the last refresh had it, with the part around the contact as it was some
  /// ticks ago. (3n) [m]. From any thread; never holds a tick up.
  void copy_positions(VectorX& x);

  TouchStatus status() const { return side_->status(); }  ///< from any thread
  const Body& body() const { return body_; }
  const TouchOptions& options() const { return options_; }
  int next_tick() const { return haptic_.next_tick(); }
  double h() const { return haptic_.h(); }  ///< [s] of a tick

  /// None after stop() or without a failure. Of the body's simulation: the ticks go on with the last local model.
  std::exception_ptr error() const noexcept { return link_ ? link_->error() : nullptr; }

  /// Who looks at the ticks. Before the first one, and before start(). Borrowed.
  void observe(TickObserver* observer) { observer_ = observer; }

  // The records of a run, while nobody ticks.
  const BodySide& slow() const { return *side_; }
  BodySide& slow() { return *side_; }
  const HapticSide& fast() const { return haptic_; }
  int lost_reports() const { return link_ ? link_->lost_reports() : 0; }

 private:
  void show_shape() noexcept;
  const Body& body_;
  TouchOptions options_;
  SurfaceFriction friction_;
  HapticSide haptic_;
  std::unique_ptr<BodySide> side_;
  TickObserver* observer_ = nullptr;
  std::unique_ptr<BodyLink> link_;  // from the first tick, or start(), on
  std::array<LocalFrame, kMaxTools> frames_;
  bool is_placed_ = false;
  double owed_ = 0;  // [s] that have passed and were not stepped
  int stale_ticks_ = 0;
  // The shape of the contact's surroundings, for copy_positions().
  std::atomic<bool> is_watched_{false};
  Mailbox<LocalMotion> shape_, free_shape_;
  std::unique_ptr<LocalMotion> next_shape_;  // of the ticking thread
  std::mutex watching_;
  std::unique_ptr<LocalMotion> shown_;  // of whoever watches
};

}  // namespace kt
