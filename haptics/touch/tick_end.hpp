#pragma once
// The ticking thread's end of a link to a body in another thread or computer: local models come, reports and motion go,
// all without a lock, and used models go back to be freed elsewhere.
#include <algorithm>
#include <atomic>

#include "haptics/halves/haptic_side.hpp"
#include "haptics/halves/model_observer.hpp"
#include "haptics/link/mailbox.hpp"
#include "haptics/link/ring.hpp"

namespace kt {

/// A local model on its way, with the tick it was made for and the tick where its state stands. It comes back with the
/// model that it took the place of, and when it did.
struct ModelParcel {
  int linearized_tick = 0, at_tick = 0, adopted_tick = -1;
  int run_in_tick = 0;  ///< it is run in by then, and not adopted before
  int frame = -1;       ///< as its maker counts
  std::unique_ptr<PreparedLocalModel> model;
};

class TickEnd {
 public:
  /// @param observer  told of each model that is adopted; null: nobody
  TickEnd(const TouchOptions& options, ModelObserver* observer);

  // In the thread that ticks.
  /// Adopts a model that has arrived, once it has caught up and is run in.
  void before_tick(HapticSide& side) noexcept;
  /// The report is lost where there is no room.
  void after_tick(HapticSide& side, const LocalReport& report) noexcept;

  // In the other thread.
  int lost_reports() const noexcept { return lost_reports_.load(std::memory_order_relaxed); }
  Ring<LocalReport>& reports() noexcept { return reports_; }
  void put(std::unique_ptr<ModelParcel> parcel) noexcept { down_.put(std::move(parcel)); }
  std::unique_ptr<ModelParcel> take_used() noexcept { return used_.take(); }
  /// Room for the motion after the next tick; false: it has some already.
  bool ask_motion(std::unique_ptr<LocalMotion>& room) noexcept {
    if (!free_motion_.is_empty()) return false;
    free_motion_.put(std::move(room));
    return true;
  }
  std::unique_ptr<LocalMotion> take_motion() noexcept { return motion_.take(); }

 private:
  void send_motion(HapticSide& side) noexcept;
  ModelObserver* observer_;
  bool catches_up_;
  Mailbox<ModelParcel> down_, used_;
  Ring<LocalReport> reports_;
  std::atomic<int> lost_reports_{0};
  Mailbox<LocalMotion> motion_, free_motion_;  // written; to be written over
  std::unique_ptr<ModelParcel> arrived_;       // of the ticking thread: not adopted yet
  std::unique_ptr<LocalMotion> next_motion_;   // of the ticking thread
};

}  // namespace kt
