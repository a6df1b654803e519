#pragma once
// The local model's coordinates after each tick, on their way from the haptic thread to the check of contacts: entries
// of changing length in a queue of fixed size, without a lock. Writing one is a copy of some hundred numbers.
#include <algorithm>
#include <atomic>
#include <vector>

#include "core/types.hpp"

namespace kt {

class MotionRecord {
 public:
  struct Tick {
    int tick = 0, frame = 0;  ///< of the model, LocalModel::frame
  };

  /// @param capacity  numbers
  explicit MotionRecord(std::size_t capacity) : numbers_(capacity) {}

  /// False, and nothing happens, when there is no room.
  bool push(const Tick& tick, const VectorX& q) noexcept {
    const auto size = static_cast<std::size_t>(q.size()) + kHead, all = numbers_.size();
    std::size_t end = end_.load(std::memory_order_relaxed);
    const std::size_t to_wrap = all - end % all, skipped = to_wrap < size ? to_wrap : 0;  // an entry is in one piece
    if (end + skipped + size - begin_.load(std::memory_order_acquire) > all) return false;
    if (skipped > 0) numbers_[end % all] = kSkip;
    end += skipped;
    double* entry = numbers_.data() + end % all;
    entry[0] = static_cast<double>(q.size());
    entry[1] = tick.tick;
    entry[2] = tick.frame;
    std::copy_n(q.data(), q.size(), entry + kHead);
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
    tick = {static_cast<int>(entry[1]), static_cast<int>(entry[2])};
    q = Eigen::Map<const VectorX>(entry + kHead, static_cast<Eigen::Index>(entry[0]));
    return true;
  }
  void pop() noexcept {  // of the entry that front() gave
    const std::size_t begin = begin_.load(std::memory_order_relaxed);
    begin_.store(begin + kHead + static_cast<std::size_t>(numbers_[begin % numbers_.size()]),
                 std::memory_order_release);
  }

 private:
  static constexpr std::size_t kHead = 3;
  static constexpr double kSkip = -1;  // in place of a size: the rest up to the end of the room is empty
  std::vector<double> numbers_;
  std::atomic<std::size_t> begin_{0}, end_{0};
};

}  // namespace kt
