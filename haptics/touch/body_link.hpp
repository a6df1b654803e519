#pragma once
// How the two halves of a Touch are joined: one file an implementation.
#include <exception>
#include <functional>
#include <memory>

#include "haptics/halves/body_side.hpp"
#include "haptics/halves/haptic_side.hpp"
#include "haptics/halves/model_observer.hpp"

namespace kt {

/// A body on another computer, as its local models tell of it.
class RemoteBody {
 public:
  virtual ~RemoteBody() = default;
  virtual TouchStatus status() const = 0;
  virtual void copy_positions(VectorX& x) const = 0;
  /// On its way to BodySide::set there; checked here before.
  virtual void set(const SettingChange& change) = 0;
};

class BodyLink {
 public:
  virtual ~BodyLink() = default;
  /// Adopts what has arrived. In the thread that ticks.
  virtual void before_tick(HapticSide& side) noexcept = 0;
  /// Takes what the tick reports.
  virtual void after_tick(HapticSide& side, const LocalReport& report) noexcept = 0;
  /// No tick comes any more: what the other half has begun is ended.
  virtual void stop() {}
  /// Why the body's simulation ended; null: it goes on.
  virtual std::exception_ptr error() const noexcept = 0;
  virtual bool has_failed() const noexcept = 0;
  virtual int lost_reports() const noexcept { return 0; }
  /// The body is on the other end of it: how it is, and where its settings go. Null: it is the BodySide that the link
  /// was made with. From any thread.
  virtual RemoteBody* remote() noexcept { return nullptr; }
};

/// Makes one for the two halves. Throws InputError or RunError: there will be no body.
using LinkMaker = std::function<std::unique_ptr<BodyLink>(BodySide& body, HapticSide& side,
                                                          const SurfaceFriction& friction, ModelObserver* observer)>;

/// Both rates in one thread: deterministic. Latency and loss are simulated in ticks, from the seed; a replay brings its
/// own schedule.
std::unique_ptr<BodyLink> make_lockstep_link(BodySide& body, ModelObserver* observer);

/// The body in a thread of its own, against the wall clock, as fast as it can up to the global rate. The first local
/// model is made at once, for the tools where `side` has them: throws what that throws.
std::unique_ptr<BodyLink> make_thread_link(BodySide& body, HapticSide& side, const SurfaceFriction& friction,
                                           ModelObserver* observer);

}  // namespace kt
