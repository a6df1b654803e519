#pragma once
// The local model's coordinates after each tick, with what the tools did in it, on their way from the haptic thread to
// the check of contacts: entries of changing length in a queue of fixed size, without a lock. Writing one is a copy of
// some hundred numbers.
#include <algorithm>
#include <atomic>
#include <span>
#include <vector>

#include "collision/shape/contact.hpp"

namespace kt {

class MotionRecord {
 public:
  /// What a tool did in a tick.
  struct Way {
    Pose from, to;
    bool is_free = true;  ///< it touched nothing
    double gap = 0;       ///< smallest of its contacts [m]
    ToolSweep sweep() const { return {from, to}; }
  };
  struct Tick {
    int tick = 0, frame = 0;  ///< of the model, LocalModel::frame
    std::array<Way, kMaxTools> tools{};
  };

  /// @param capacity  numbers
  explicit MotionRecord(std::size_t capacity) : numbers_(capacity) {}

  /// False, and nothing happens, when there is no room.
  /// @param more  numbers after those of q
  bool push(const Tick& tick, const VectorX& q, std::span<const double> more = {}) noexcept {
    const auto size = static_cast<std::size_t>(q.size()) + more.size() + kHead, all = numbers_.size();
    std::size_t end = end_.load(std::memory_order_relaxed);
    const std::size_t to_wrap = all - end % all, skipped = to_wrap < size ? to_wrap : 0;  // an entry is in one piece
    if (end + skipped + size - begin_.load(std::memory_order_acquire) > all) return false;
    if (skipped > 0) numbers_[end % all] = kSkip;
    end += skipped;
    double* entry = numbers_.data() + end % all;
    *entry++ = static_cast<double>(size - kHead);
    *entry++ = tick.tick;
    *entry++ = tick.frame;
    for (const Way& way : tick.tools) {
      for (const Pose* pose : {&way.from, &way.to}) {
        entry = std::copy_n(pose->x.data(), 3, entry);
        entry = std::copy_n(pose->r.coeffs().data(), 4, entry);
      }
      *entry++ = way.is_free;
      *entry++ = way.gap;
    }
    entry = std::copy_n(q.data(), q.size(), entry);
    std::ranges::copy(more, entry);
    end_.store(end + size, std::memory_order_release);
    return true;
  }

  /// The oldest entry, which stays; false: there is none.
  bool front(Tick& tick, VectorX& q) noexcept {
    std::size_t begin = begin_.load(std::memory_order_relaxed);
    const std::size_t all = numbers_.size();
    if (begin == end_.load(std::memory_order_acquire)) return false;
    if (numbers_[begin % all] == kSkip) begin_.store(begin += all - begin % all, std::memory_order_release);
    const double* entry = numbers_.data() + begin % all;
    const auto size = static_cast<Eigen::Index>(*entry++);
    tick.tick = static_cast<int>(*entry++);
    tick.frame = static_cast<int>(*entry++);
    for (Way& way : tick.tools) {
      for (Pose* pose : {&way.from, &way.to}) {
        std::copy_n(entry, 3, pose->x.data());
        std::copy_n(entry + 3, 4, pose->r.coeffs().data());
        entry += 7;
      }
      way.is_free = *entry++ != 0;
      way.gap = *entry++;
    }
    q = Eigen::Map<const VectorX>(entry, size);
    return true;
  }
  void pop() noexcept {  // of the entry that front() gave
    const std::size_t begin = begin_.load(std::memory_order_relaxed);
    begin_.store(begin + kHead + static_cast<std::size_t>(numbers_[begin % numbers_.size()]),
                 std::memory_order_release);
  }

 private:
  static constexpr std::size_t kHead = 3 + 16 * kMaxTools;
  static constexpr double kSkip = -1;  // in place of a size: the rest up to the end of the room is empty
  std::vector<double> numbers_;
  std::atomic<std::size_t> begin_{0}, end_{0};
};

}  // namespace kt
