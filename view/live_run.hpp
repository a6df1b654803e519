#pragma once
// A scene that runs until it is told otherwise: the engine in its threads, the tool's hand drawn by a pointer, records
// when they are asked for. What a page shows is copied out of it and never waits for a tick.
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>

#include "haptics/device/moved_target.hpp"
#include "haptics/halves/live_settings.hpp"
#include "haptics/session/body_film.hpp"
#include "haptics/session/real_time.hpp"
#include "haptics/session/session.hpp"
#include "view/frame_bytes.hpp"

namespace kt {

/// For the gauges.
struct LiveStatus {
  TouchStatus touch;
  double refresh_hz = 0, wanted_hz = 0;     ///< over the last seconds
  double tick_p50_us = 0, tick_p99_us = 0;  ///< of the last ticks
  long long ticks = 0, misses = 0;          ///< since the start; whose time was over the period
  long long allocations = 0;                ///< in the ticks
  std::string gate;                         ///< of a device that somebody holds: open, shut; empty: there is none
  RealTime real_time;                       ///< over the last seconds
  double frame_us = 0;                      ///< CPU time of the server for a picture
  bool is_paused = false, is_recording = false;
  /// Of the recording [s]; not a number: it has not begun, the body comes to rest first.
  double recorded_s = std::numeric_limits<double>::quiet_NaN();
  std::string told;   ///< instead of what real_time tells; empty: that
  std::string error;  ///< why it stands still; empty: it does not
};

class LiveRun final : private SessionWatcher {
 public:
  /// Writes a recording. @returns where it lies
  using Save = std::function<std::string(const Session&, const SessionResult&, const BodyFilm&)>;
  /// Told of a recording: where it lies, or why it could not be written. In the run's own thread.
  using Told = std::function<void(const std::string& folder, const std::string& error)>;
  /// A new session with the body's computer. Throws InputError and RunError.
  using NewLink = std::function<LinkMaker()>;

  /// Builds the body, which stands still until start(). Throws InputError for what is wrong with the scene.
  /// @param by_pointer  the first tool is drawn by move(); else it goes the scene's way, again and again
  /// @param new_link    the body is on another computer; none: it is here
  LiveRun(const Scene& scene, bool by_pointer, Save save, Told told, std::function<long long()> count_allocations,
          NewLink new_link = {});
  ~LiveRun() override;
  LiveRun(const LiveRun&) = delete;
  LiveRun& operator=(const LiveRun&) = delete;

  /// Lets it run, once.
  /// @param before  ends first, and closes its device: no two runs hold one at a time. None: there is none
  void start(std::unique_ptr<LiveRun> before);

  const Session& session() const { return session_; }
  const BodyShape& shape() const { return shape_; }

  // From one other thread.
  void move(const Vec3& target);
  void retreat();  ///< nobody holds the pointer any more: the tool leaves the body along the last normal
  void pause(bool on);
  void reset();  ///< the body at rest, the tool at its start; settings stay as they were set
  /// From rest on, until it is turned off: so that a replay can begin where the recording did. Turned off before it
  /// has begun: nothing is kept.
  void record(bool on);
  /// As Touch::set, from the next run on where none is under way. Throws InputError.
  void set(const std::string& key, const std::string& value);
  std::string setting(const std::string& key) const;  ///< of the next run where none is under way

  /// A frame for the page: what is new since the last one. False: nothing has been ticked yet.
  struct Picture {
    double t = 0;
    int refreshes = 0;
    Vec3 target = Vec3::Zero();
    std::vector<LocalFrame> tools;
    std::vector<TickForce> ticks;
    PackedPositions positions;
  };
  bool take(Picture& out);
  /// The patch and the error of a refresh that was not taken yet.
  bool take_refresh(RefreshPicture& out);
  LiveStatus status();

 private:
  void begun(Touch& touch) override;
  void ticked(std::span<const LocalFrame> frames, double step_us, long long allocations) override;
  void refreshed(const RefreshRecord& record) override;
  void ended() override;
  void go_on();
  void run_once();
  void remember(const SettingChange& change);
  LiveCopy next_values() const;  ///< that the next run begins with
  void require_next(const SettingChange& change) const;
  bool is_kept() const { return keeps_ && touch_ && !newest_.tools.empty(); }  ///< what is touched now
  Vec3 first_place() const { return session_.path().front().x; }

  Session session_;
  const bool by_pointer_;
  const Save save_;
  const Told told_;
  const std::function<long long()> count_allocations_;
  const NewLink new_link_;
  BodyShape shape_;

  std::atomic<bool> stop_{false}, pause_{false}, quits_{false};
  mutable std::mutex guard_;  // of what follows; never taken in a tick
  std::condition_variable wakes_;
  Touch* touch_ = nullptr;
  std::shared_ptr<MovedTarget> target_;
  Vec3 last_target_ = Vec3::Zero();
  bool records_ = false, keeps_ = false, waits_ = false;  // asked for; of the run that is under way; for reset()
  std::string error_;
  std::vector<SettingChange> changed_;  // that stay over a reset
  Picture newest_;
  std::vector<float> step_us_;  // of the last ticks, in a ring
  long long ticks_ = 0, misses_ = 0, allocations_ = 0;
  int shown_refresh_ = 0;
  std::deque<RefreshRecord> refreshes_;  // of the last seconds
  VectorX x_;
  std::thread thread_;
};

}  // namespace kt
