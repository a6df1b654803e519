#pragma once
// In how many ticks each flag was set: what an own loop is told afterwards in words.
#include <array>
#include <atomic>
#include <bit>
#include <string>
#include <vector>

namespace kt {

class FlagCounts {
 public:
  /// @param flags  of one tick, all tools: LocalFlag. By the ticking thread alone; no allocation
  void add(unsigned flags) noexcept {
    ticks_.store(ticks_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    for (; flags != 0; flags &= flags - 1) {
      auto& count = counts_[static_cast<std::size_t>(std::countr_zero(flags)) % counts_.size()];
      count.store(count.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    }
  }
  /// A line for each flag that speaks against the forces. From any thread.
  std::vector<std::string> warnings() const;

 private:
  std::atomic<long> ticks_{0};
  std::array<std::atomic<long>, 32> counts_{};
};

}  // namespace kt
