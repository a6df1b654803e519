#pragma once
// A queue between one writer and one reader thread, of fixed size, without a lock.
#include <atomic>
#include <vector>

namespace kt {

template <class T>
class Ring {
 public:
  explicit Ring(std::size_t capacity) : items_(capacity) {}
  /// False, and nothing happens, when the queue is full.
  bool push(const T& item) noexcept {
    const std::size_t end = end_.load(std::memory_order_relaxed);
    if (end - begin_.load(std::memory_order_acquire) == items_.size()) return false;
    items_[end % items_.size()] = item;
    end_.store(end + 1, std::memory_order_release);
    return true;
  }
  bool pop(T& item) noexcept {
    const std::size_t begin = begin_.load(std::memory_order_relaxed);
    if (begin == end_.load(std::memory_order_acquire)) return false;
    item = items_[begin % items_.size()];
    begin_.store(begin + 1, std::memory_order_release);
    return true;
  }
  /// For the reader: what is there at least.
  std::size_t size() const noexcept {
    return end_.load(std::memory_order_acquire) - begin_.load(std::memory_order_relaxed);
  }

 private:
  std::vector<T> items_;
  std::atomic<std::size_t> begin_{0}, end_{0};
};

}  // namespace kt
