#pragma once
// Hands one object at a time from one thread to another without a lock: a newer one replaces an older one not yet
// taken.
#include <atomic>
#include <memory>

namespace kt {

template <class T>
class Mailbox {
 public:
  ~Mailbox() { delete slot_.load(); }
  /// Puts an object in; gives back the one that nobody took.
  std::unique_ptr<T> put(std::unique_ptr<T> object) noexcept {
    return std::unique_ptr<T>(slot_.exchange(object.release(), std::memory_order_acq_rel));
  }
  /// Takes what is there, or nothing.
  std::unique_ptr<T> take() noexcept { return std::unique_ptr<T>(slot_.exchange(nullptr, std::memory_order_acq_rel)); }
  bool is_empty() const noexcept { return slot_.load(std::memory_order_acquire) == nullptr; }

 private:
  std::atomic<T*> slot_{nullptr};
};

}  // namespace kt
