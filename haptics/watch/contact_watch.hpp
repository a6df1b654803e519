#pragma once
// Watches a touch for contact that should be and is not: the whole body is looked at after every tick, at once where
// the body's half waits for the ticks, else later in its thread.
#include <atomic>

#include "core/base/record.hpp"
#include "haptics/halves/haptic_side.hpp"
#include "haptics/halves/model_observer.hpp"
#include "haptics/link/motion_record.hpp"
#include "haptics/tick/body_check.hpp"
#include "haptics/watch/lost_contact.hpp"

namespace kt {

class ContactWatch final : public ModelObserver {
 public:
  /// @param surface  of the whole body; borrowed
  /// @param later    the ticking thread only notes what there is to look at
  /// @param h        tick [s]: the notes have room for a time, not for a number of ticks
  /// @param keeps    the depths of all ticks: take_penetration()
  ContactWatch(const Surface& surface, std::span<const ToolShape> tools, bool later, double h = 1e-3,
               bool keeps = true);

  void adopted(const PreparedLocalModel& model) noexcept override;
  /// A tick is done; for whoever ticks to call, outside the tick's time. No allocation when it is looked at later.
  void ticked(const HapticSide& side, std::span<const LocalFrame> frames) noexcept;
  bool look_back(const PreparedLocalModel& model, int most) override;
  /// The ticks that are left, all of which had this model. While nobody ticks.
  void finish(const PreparedLocalModel& model);

  LostContact lost(std::size_t tool) const;
  /// After each tick, into the whole body [m].
  Record<double> take_penetration(std::size_t tool) { return std::move(penetration_[tool]); }

 private:
  void look(const MotionRecord::Tick& tick, const VectorX& q);
  bool note_depth(std::size_t tool, int tick, double depth);
  std::size_t tools_;
  bool keeps_;
  BodyCheck check_;
  std::unique_ptr<MotionRecord> record_;  // of ticks that are looked at later
  std::array<LostContact, kMaxTools> lost_;
  std::atomic<int> unnoted_{0};  // ticks that record_ had no room for
  std::array<Record<double>, kMaxTools> penetration_;
  VectorX past_q_;
  int past_frame_ = -1;
};

}  // namespace kt
