#pragma once
// A recorded session, run again and kept as pictures: for a time line.
#include "haptics/session/session.hpp"
#include "view/live_run.hpp"

namespace kt {

class Playback final : private SessionWatcher {
 public:
  /// Runs the session again. Throws InputError; RunError when it was stopped.
  /// @param files   that the session holds, of those that its scene names
  /// @param replay  what the session did: SessionOptions of `kilotouch replay`
  Playback(const Scene& scene, SceneFiles files, SessionOptions replay);

  const Session& session() const { return session_; }
  const BodyShape& shape() const { return shape_; }
  const SessionResult& result() const { return result_; }
  double duration() const { return pictures_.empty() ? 0 : pictures_.back().t; }
  std::span<const TickForce> ticks() const { return ticks_; }
  /// The body as it was last at or before t [s].
  const LiveRun::Picture& at(double t) const;
  /// Of the refresh that was last at or before t.
  const RefreshPicture& refresh_at(double t) const;

 private:
  void begun(Touch& touch) override { touch_ = &touch; }
  void ticked(std::span<const LocalFrame> frames, double step_us, long long allocations) override;

  Session session_;
  BodyShape shape_;
  SessionResult result_;
  Touch* touch_ = nullptr;
  int every_ = 33;  // ticks
  std::vector<LiveRun::Picture> pictures_;
  std::vector<RefreshPicture> refreshes_;
  std::vector<TickForce> ticks_;
};

}  // namespace kt
