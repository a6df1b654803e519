#pragma once
#include <mutex>
#include <span>
#include <vector>

#include "haptics/halves/pose_history.hpp"
#include "haptics/tick/local_report.hpp"

namespace kt {

/// Where the tools were, written by one thread and read by another.
class SharedHistory {
 public:
  static constexpr int kTicks = 1 << 15;  ///< that a new local model can be late
  SharedHistory(std::span<const Pose> start, int tick)
      : tools_(start.size()), poses_(tools_, kTicks), first_(tick), end_(tick) {
    for (std::size_t k = 0; k < tools_; ++k) poses_.put(tick, k, start[k]);
  }
  void add(const LocalReport& report) {
    const std::scoped_lock lock(guard_);
    for (std::size_t k = 0; k < tools_; ++k) poses_.put(report.tick + 1, k, report.tools[k].pose);
    end_ = report.tick + 1;
  }
  /// Sweeps of the ticks from `tick` on, as many as there are; by ticks. None: it is too long ago.
  std::vector<ToolSweep> from(int tick) const {
    const std::scoped_lock lock(guard_);
    std::vector<ToolSweep> out;
    if (tick < first_ || end_ - tick > poses_.reach()) return out;
    for (; tick < end_; ++tick)
      for (std::size_t k = 0; k < tools_; ++k) out.push_back(poses_.sweep(tick, k));
    return out;
  }
  int end() const {
    const std::scoped_lock lock(guard_);
    return end_;
  }
  std::vector<Pose> last() const {
    const std::scoped_lock lock(guard_);
    std::vector<Pose> out;
    for (std::size_t k = 0; k < tools_; ++k) out.push_back(poses_.get(end_, k));
    return out;
  }
  /// A report was lost on the way from the ticks: what was before cannot be replayed.
  void begin_anew(const LocalReport& report) {
    {
      const std::scoped_lock lock(guard_);
      first_ = report.tick + 1;
    }
    add(report);
  }

 private:
  std::size_t tools_;
  PoseHistory poses_;
  int first_, end_;
  mutable std::mutex guard_;
};

}  // namespace kt
