#pragma once
// The body's half of a touch whose other half is on another computer: reports and motion in, local models out. No
// socket and no clock here: a test drives it in virtual time.
#include <chrono>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>

#include "haptics/halves/body_side.hpp"
#include "haptics/remote/report_box.hpp"
#include "network/message/messages.hpp"

namespace kt {

struct BodyEndCounts {
  int models = 0;   ///< made
  int reports = 0;  ///< messages that came
  int motions = 0;  ///< the same
  int misfits = 0;  ///< motions of a local model that is not known, or of another size
  ReportInbox::Counts inbox{};
};

class BodyEnd {
 public:
  /// @param body     borrowed     @param options  of the session, link.type network, with what the hand's side told
  /// @param observer is told of each refresh; none: nobody
  BodyEnd(const Body& body, TouchOptions options, ModelObserver* observer);

  /// The first local model, for tools that are there. Throws what a refresh throws.
  ModelMessage begin(std::span<const Pose> tools);

  // From the thread that receives.
  void take(ReportMessage message);
  void take(MotionMessage message);

  // From the body's thread.
  /// The next local model, when one is due. Throws what a refresh throws.
  std::optional<ModelMessage> refresh_if_due();
  /// Until something has come, or so long.
  void wait(std::chrono::milliseconds most);
  /// No refresh comes any more: the observer is told of those that it was not told of.
  void finish() { side_.finish(); }

  /// As BodySide::set; from any thread.
  void set(const SettingChange& change);
  TouchStatus status() const { return side_.status(); }
  void copy_positions(VectorX& x) const { side_.copy_positions(x); }
  std::optional<double> model_loss() const;  ///< of datagrams to the hand, as it has told; none: not yet
  BodyEndCounts counts() const;
  /// The last report that came.
  LocalReport last_report() const;
  double h() const { return h_; }

 private:
  /// Of a local model that may be in use.
  struct Kept {
    int linearized_tick = 0, recovered = 0, patch = 0;
    std::vector<int> row;  // (n) as LocalMotion::row
  };
  ModelMessage packed(const PreparedLocalModel& model);
  void follow_adoption(const ReportBatch& batch);
  int expected_age() const;

  double h_;
  BodySide side_;
  ReportInbox inbox_;
  std::map<int, Kept> kept_;  // by frame
  std::deque<int> ages_;      // of the last local models that were taken [ticks]
  int last_ = 0, due_, interval_, usual_, age_ = 0, adopted_frame_ = 0;

  mutable std::mutex guard_;  // of what follows
  std::condition_variable came_;
  std::vector<ReportBatch> batches_;
  std::optional<MotionMessage> motion_;
  std::chrono::steady_clock::time_point motion_came_{};
  std::optional<double> loss_;
  BodyEndCounts counts_;
  LocalReport last_report_;
};

}  // namespace kt
