#pragma once
// The engine: a body that tools touch, one call a haptic tick. Scene files, devices, records and commands are made on
// top of it (session/), and so is a loop of one's own: docs/embedding.md.
#include <exception>
#include <functional>
#include <span>

#include "haptics/options/touch_options.hpp"
#include "haptics/tick/local_frame.hpp"
#include "haptics/touch/body.hpp"
#include "haptics/touch/touch_status.hpp"

namespace kt {

struct TickContact;      // haptics/tick/tick_contact.hpp
struct SurfaceFriction;  // haptics/contact/friction.hpp
class BodyLink;          // haptics/touch/body_link.hpp
class BodySide;
class HapticSide;
class ModelObserver;
using LinkMaker = std::function<std::unique_ptr<BodyLink>(BodySide& body, HapticSide& side,
                                                          const SurfaceFriction& friction, ModelObserver* observer)>;

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

  /// Where the tools are before the first tick; without it, where the first tick has them. Throws InputError for a pose
  /// that is not finite, no rotation, or beyond 1e6 m.
  void place(std::span<const Pose> tools);
  void place(const Pose& tool) { place({&tool, 1}); }

  /// The body from now on in a thread of its own. After place(), before the first tick; throws what its first refresh
  /// throws.
  void start();
  /// The body at the other end of a link of one's own (network/hand_link.hpp). After place(), before the first tick;
  /// throws what the maker throws.
  void start(const LinkMaker& make);
  /// Ends that thread; ticks go on with the last local model. Throws what ended the body's simulation before.
  void stop();

  /// Back to before the first tick: the body as it is at its start, nothing placed, settings as they were set last. A
  /// thread of the body's own ends; start() begins another one. While nobody else uses the touch.
  void reset();

  /// One haptic tick: the tools have come to these poses, world frame, each the same tool in every tick. A frame for
  /// each, which is there until the next tick. Forces are finite: a pose that is not leaves the tool where it was, and
  /// LocalFrame::flags says so; of a tool that was nowhere yet the touch has not begun. After start(): no allocation,
  /// lock or clock.
  std::span<const LocalFrame> tick(std::span<const Pose> tools) noexcept;
  const LocalFrame& tick(const Pose& tool) noexcept { return tick(std::span(&tool, 1))[0]; }

  /// The same for a loop that does not keep the rate: `dt` [s] have passed since the last call, in which the tools came
  /// here evenly. As many steps of 1 / local.rate_hz as fit are done, also none; more than most_steps() are left
  /// out (kLateTick).
  std::span<const LocalFrame> tick(std::span<const Pose> tools, double dt) noexcept;
  const LocalFrame& tick(const Pose& tool, double dt) noexcept { return tick(std::span(&tool, 1), dt)[0]; }
  static constexpr double kMostTime = 0.02;  ///< [s] that one call makes up for: a picture of a slow screen
  static constexpr int kMostSteps = 20;      ///< or so many steps, where these last longer
  int most_steps() const noexcept;           ///< of one call

  /// What tick() would do first: without start(), the refresh that is due. To take its time apart from the tick's.
  void refresh_if_due() noexcept;

  /// A setting, while the body is touched: live_settings(). From the next refresh on, booked in changes(). From any
  /// thread. Throws InputError: what, value, allowed range; nothing is changed then.
  void set(const std::string& key, double value);
  void set(const std::string& key, const std::string& word);
  double number(const std::string& key) const;  ///< as it was set last
  std::string word(const std::string& key) const;

  /// Where the whole body is, for drawing: as the last refresh had it, with the part around the contact as it was some
  /// ticks ago. (3n) [m]. From any thread; never holds a tick up.
  void copy_positions(VectorX& x);
  void copy_positions_now(VectorX& x);  ///< as they are now: while nobody ticks, without a thread of the body's own

  /// What speaks against the forces so far, a line each, in the words of the command: of the body as it was loaded; of
  /// the ticks, by their flags and by the residual of their contact forces; of tools that were inside the whole body,
  /// went into it or through it, or lost contact, in ticks until some refreshes ago, after stop() in all;
  /// of refreshes whose tangent was indefinite or whose tetrahedra were inside out; without start(), of a surface with
  /// self-contact that crossed itself or is pressed onto itself. Not of a body without self-contact that passes through
  /// itself: to look for that takes too long; `Session` and the command do, after a run. Of a body on another computer,
  /// not of its refreshes. From any thread.
  std::vector<std::string> warnings() const;
  /// False: ticks and refreshes are not looked at for warnings(), beyond the ticks' own flags. Before the first tick.
  void check_contacts(bool on);

  TouchStatus status() const;                        ///< from any thread
  void copy_refresh(RefreshPicture& picture) const;  ///< the patch and the error of the last refresh; from any thread
  /// What the last tick did to the body, at each contact of all tools.
  std::span<const TickContact> last_samples() const noexcept;

  const Body& body() const;
  const TouchOptions& options() const;
  std::size_t num_tools() const;
  int next_tick() const noexcept;
  double h() const noexcept;  ///< [s] of a tick

  /// Why the body's simulation ended; none as a rule. Ticks go on with the last local model.
  std::exception_ptr error() const noexcept;

  /// Who follows the local models. Before the first tick, and before start(). Borrowed.
  void observe(ModelObserver* observer);

  // The halves and their records, while nobody ticks.
  BodySide& slow();
  const BodySide& slow() const;
  const HapticSide& fast() const;
  int lost_reports() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace kt
