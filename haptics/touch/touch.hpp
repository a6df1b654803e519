#pragma once
// The engine: a body that tools touch, one call a haptic tick. Scene files, devices, records and commands are made on
// top of it (session/), and so is a loop of one's own: docs/embedding.md.
#include <exception>
#include <memory>
#include <span>

#include "haptics/body/body.hpp"
#include "haptics/halves/touch_status.hpp"
#include "haptics/options/touch_options.hpp"
#include "haptics/tick/local_frame.hpp"

namespace kt {

/// One thread at a time ticks. Without start() the body is refreshed inside some of the ticks, deterministic: the same
/// poses give the same bits, and a refresh takes its tens of milliseconds. After start() the body has its own thread,
/// and a tick never waits for it.
class Touch {
 public:
  /// Throws InputError for settings that are wrong or do not go together.
  /// @param body  kept by reference; must outlive the Touch
  explicit Touch(const Body& body, TouchOptions options = {});
  ~Touch();
  Touch(const Touch&) = delete;
  Touch& operator=(const Touch&) = delete;

  /// Poses of the tools before the first tick. Without a call, the first tick gives them. Throws InputError for a pose
  /// that is not finite, no rotation, or beyond 1e6 m.
  void place(std::span<const Pose> tools);
  void place(const Pose& tool) { place({&tool, 1}); }

  /// Starts the body's thread. Call after place() and before the first tick. Throws what the first refresh throws.
  void start();
  /// Ends that thread; ticks go on with the last local model. Throws what ended the body's simulation before.
  void stop();

  /// Back to before the first tick: the body as it is at its start, nothing placed, settings as they were set last. A
  /// thread of the body's own ends; start() begins another one. While nobody else uses the touch.
  void reset();

  /// One haptic tick with the tools at these poses (world frame, same order in every tick). Returns one frame per tool,
  /// valid until the next tick. Forces are always finite: a pose that is not finite leaves its tool in place and sets a
  /// flag (LocalFrame::flags). After start(), a tick uses no allocation, lock or clock.
  std::span<const LocalFrame> tick(std::span<const Pose> tools) noexcept;
  const LocalFrame& tick(const Pose& tool) noexcept { return tick(std::span(&tool, 1))[0]; }

  /// For a loop at another rate: `dt` [s] is the time since the last call, over which the tools moved evenly. Does as
  /// many steps of 1 / local.rate_hz as fit, possibly none, at most most_steps() (else kLateTick).
  std::span<const LocalFrame> tick(std::span<const Pose> tools, double dt) noexcept;
  const LocalFrame& tick(const Pose& tool, double dt) noexcept { return tick(std::span(&tool, 1), dt)[0]; }
  static constexpr double kMostTime = 0.02;  ///< [s] that one call makes up for: a picture of a slow screen
  static constexpr int kMostSteps = 20;      ///< or so many steps, where these last longer
  int most_steps() const noexcept;           ///< of one call

  /// Changes one of live_settings() while the body is touched, from the next refresh on. From any thread. Throws
  /// InputError (what, value, allowed range) and changes nothing then.
  void set(const std::string& key, double value);
  void set(const std::string& key, const std::string& word);
  double number(const std::string& key) const;  ///< as it was set last
  std::string word(const std::string& key) const;

  /// Positions of the whole body for drawing, (3n) [m]: those of the last refresh, around the contact those of some
  /// ticks ago. From any thread; never delays a tick.
  void copy_positions(VectorX& x);

  /// What speaks against the forces so far, in the words of the command: of the body as it was loaded; of
  /// the ticks, by their flags and by the residual of their contact forces; of tools that were inside the whole body,
  /// went into it or through it, or lost contact, in ticks until some refreshes ago, after stop() in all;
  /// of refreshes whose tangent was indefinite or whose tetrahedra were inside out; without start(), of a surface with
  /// self-contact that crossed itself or is pressed onto itself. Not of a body without self-contact that passes through
  /// itself: to look for that takes too long; `Session` and the command do, after a run. Of a body on another computer,
  /// not of its refreshes. From any thread.
  std::vector<Finding> findings() const;
  /// False: ticks and refreshes are not looked at for findings(), beyond the ticks' own flags. Before the first tick.
  void check_contacts(bool on);

  TouchStatus status() const;                        ///< from any thread
  void copy_refresh(RefreshPicture& picture) const;  ///< the patch and the error of the last refresh; from any thread
  const Body& body() const;
  const TouchOptions& options() const;
  std::size_t num_tools() const;
  int next_tick() const noexcept;
  double h() const noexcept;  ///< [s] of a tick

  /// Why the body's simulation ended; none as a rule. Ticks go on with the last local model.
  std::exception_ptr error() const noexcept;

 private:
  friend struct TouchHalves;  // haptics/touch/touch_halves.hpp
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace kt
