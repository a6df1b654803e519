#pragma once
// Where the tools were in the ticks before: a fixed number of them, the oldest written over.
#include <vector>

#include "collision/shape/contact.hpp"

namespace kt {

/// Poses at the starts of ticks: those at 0 before the first tick, those at n after n ticks. No allocation once made.
class PoseHistory {
 public:
  PoseHistory(std::size_t tools, std::size_t ticks) : tools_(tools), poses_(tools * ticks) {}

  void put(int tick, std::size_t tool, const Pose& pose) noexcept { poses_[at(tick, tool)] = pose; }
  const Pose& get(int tick, std::size_t tool) const noexcept { return poses_[at(tick, tool)]; }
  /// How many ticks back from the newest are there.
  int reach() const noexcept { return static_cast<int>(poses_.size() / tools_) - 1; }
  /// During a tick.
  ToolSweep sweep(int tick, std::size_t tool) const noexcept { return {get(tick, tool), get(tick + 1, tool)}; }

 private:
  std::size_t at(int tick, std::size_t tool) const noexcept {
    return static_cast<std::size_t>(tick) % (poses_.size() / tools_) * tools_ + tool;
  }
  std::size_t tools_;
  std::vector<Pose> poses_;
};

}  // namespace kt
