#pragma once
// In how many ticks of a tool each flag was set, and contact forces were not found: what an own loop is told
// afterwards.
#include <array>
#include <atomic>
#include <bit>

#include "haptics/watch/tick_words.hpp"

namespace kt {

/// Newer local models under a moving tool, in a loop of one's own.
std::vector<Cure> sooner_models();

class FlagCounts {
 public:
  /// A tick of the tool. By the ticking thread alone; no allocation.
  /// @param flags  LocalFlag      @param t  its end [s]
  void add(unsigned flags, double residual, double t) noexcept {
    ticks_.store(ticks_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    if (residual > kNoticeableResidual) unsolved_.add(t);
    for (; flags != 0; flags &= flags - 1) flags_[static_cast<std::size_t>(std::countr_zero(flags))].add(t);
  }
  /// A call that did no tick.
  void add_call(LocalFlag flag, double t) noexcept {
    flags_[static_cast<std::size_t>(std::countr_zero<unsigned>(flag))].add(t);
  }

  // From any thread.
  TickCount ticks(LocalFlag flag) const {
    return flags_[static_cast<std::size_t>(std::countr_zero<unsigned>(flag))].of(all());
  }
  TickCount unsolved() const { return unsolved_.of(all()); }
  long all() const { return ticks_.load(std::memory_order_relaxed); }
  /// What speaks against the forces.
  /// @param is_remote    the body is on another computer
  /// @param keeps_cells  refined cells stay at their first place
  void tell(std::size_t tool, bool is_remote, bool keeps_cells, std::vector<Finding>& out) const;

 private:
  struct Count {
    std::atomic<long> count{0};
    std::atomic<double> first{0};  // [s]
    void add(double t) noexcept {
      const long before = count.load(std::memory_order_relaxed);
      if (before == 0) first.store(t, std::memory_order_relaxed);
      count.store(before + 1, std::memory_order_relaxed);
    }
    TickCount of(long all) const {
      return {count.load(std::memory_order_relaxed), all, first.load(std::memory_order_relaxed)};
    }
  };
  std::atomic<long> ticks_{0};
  std::array<Count, 32> flags_{};
  Count unsolved_;
};

}  // namespace kt
