#pragma once
// The engine, a body that tools touch, one call a haptic tick. Scene files, devices, records and commands are made on
// top of it (session/), and so is a loop of one's own (docs/embedding.md).
#include <exception>
#include <memory>
#include <span>

#include "haptics/body/body.hpp"
#include "haptics/halves/touch_status.hpp"
#include "haptics/options/touch_options.hpp"
#include "haptics/tick/local_frame.hpp"

namespace kt {

/// One thread at a time ticks. Without start() the body is refreshed inside some of the ticks, deterministic. The same
/// poses give the same bits, and a refresh takes its tens of milliseconds. After start() the body has its own thread,
/// and a tick never waits for it.
class Touch {
 public:
  /// Throws InputError for settings that are wrong or do not go together.
  /// @param body  kept by reference, must outlive the Touch
  explicit Touch(const Body& body, TouchOptions options = {});
  ~Touch();
  Touch(const Touch&) = delete;
  Touch& operator=(const Touch&) = delete;

  /// Poses of the tools before the first tick. Without a call, the first tick gives them. Throws InputError for a pose
  /// that is not finite, no rotation, or beyond 1e6 m.
  void place(std::span<const Pose> tools);
  void place(const Pose& tool) { place({&tool, 1}); }

  /// Starts the body's thread. Call after place() and before the first tick. Throws the exception of the first refresh.
  void start();
  /// Ends that thread. Ticks go on with the last local model. Throws the exception that ended the body's simulation
  /// before.
  void stop();

  /// Back to before the first tick, with the body as it is at its start, nothing placed, settings as they were set
  /// last. A thread of the body's own ends, and start() begins another one. Not while another thread uses the touch.
  void reset();

  /// The same, but the body goes on from that state, of this touch or of another one of the same body, and the tools
  /// are where they were. Nothing is set up anew, the same state gives the same bits. Settings are those of this touch.
  /// Tools that place() puts elsewhere have no contact before the first tick. Throws InputError, and changes nothing
  /// then, for a state of another body or of other tools, and with contacts for other methods than multirate with
  /// coulomb.
  void reset(const TouchState& state);
  /// The state now, before the first tick that of the start. Not while another thread ticks. Throws MisuseError for a
  /// body on another computer.
  TouchState state() const;

  /// One haptic tick with the tools at these poses (world frame, same order in every tick). Returns one frame per tool,
  /// valid until the next tick. Forces are always finite. A pose that is not finite leaves its tool in place and sets a
  /// flag (LocalFrame::flags). After start(), a tick uses no allocation, lock or clock.
  std::span<const LocalFrame> tick(std::span<const Pose> tools) noexcept;
  const LocalFrame& tick(const Pose& tool) noexcept { return tick(std::span(&tool, 1))[0]; }

  /// For a loop at another rate. `dt` [s] is the time since the last call, over which the tools moved evenly. Does as
  /// many steps of 1 / local.rate_hz as fit, possibly none, at most those of kMostTime or kMostSteps, whichever are
  /// more (else kLateTick).
  std::span<const LocalFrame> tick(std::span<const Pose> tools, double dt) noexcept;
  const LocalFrame& tick(const Pose& tool, double dt) noexcept { return tick(std::span(&tool, 1), dt)[0]; }
  static constexpr double kMostTime = 0.02;  ///< [s] that one call makes up for, a picture of a slow screen
  static constexpr int kMostSteps = 20;      ///< or so many steps, where these last longer

  /// Changes one of live_settings() while the body is touched, from the next refresh on. From any thread. Throws
  /// InputError (quantity, value, allowed range) and changes nothing then.
  void set(const std::string& key, double value);
  void set(const std::string& key, const std::string& word);
  double number(const std::string& key) const;  ///< as it was set last
  std::string word(const std::string& key) const;

  /// Positions of the whole body for drawing, (3n) [m], those of the last refresh, around the contact those of some
  /// ticks ago. From any thread. Never delays a tick.
  void copy_positions(VectorX& x);

  /// Facts against the forces so far, in the words of the command. They are about
  /// - the body as it was loaded,
  /// - ticks, by their flags and by the residual of their contact forces,
  /// - tools that were inside the whole body, went into it or through it, or lost contact, in ticks until some
  /// refreshes
  ///   ago, after stop() in all,
  /// - refreshes whose tangent was indefinite or whose tetrahedra were inside out, but for a body on another computer,
  /// - without start(), a surface with self-contact that crossed itself or is pressed onto itself.
  ///
  /// A body without self-contact that passes through itself is found by `Session` and the command only, after a run,
  /// since the search takes too long. From any thread.
  std::vector<Finding> findings() const;
  /// With false, ticks and refreshes are not looked at for findings(), beyond the ticks' own flags. Before the first
  /// tick.
  void check_contacts(bool on);

  TouchStatus status() const;                        ///< from any thread
  void copy_refresh(RefreshPicture& picture) const;  ///< patch and error of the last refresh, from any thread
  const Body& body() const;
  const TouchOptions& options() const;
  std::size_t num_tools() const;
  int next_tick() const noexcept;
  double h() const noexcept;  ///< [s] of a tick

  /// The reason of the end of the body's simulation, none as a rule. Ticks go on with the last local model.
  std::exception_ptr error() const noexcept;

 private:
  friend struct TouchHalves;  // haptics/touch/touch_halves.hpp
  struct Parts;
  void renew(const TouchState* from);
  std::unique_ptr<Parts> parts_;
};

}  // namespace kt
