#pragma once
// One value between a thread that writes it and a thread that reads it, neither of which ever waits: a sequence lock
// of atomic words (Boehm 2012). Words are released and acquired one by one in place of fences, which ThreadSanitizer
// does not know.
#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace kt {

template <class T>
class Slot {
  static_assert(std::is_trivially_copyable_v<T> && sizeof(T) % 8 == 0);
  static constexpr std::size_t kWords = sizeof(T) / 8;

 public:
  Slot() { put(T{}); }

  /// From one thread at a time.
  void put(const T& value) noexcept {
    std::array<std::uint64_t, kWords> words;
    std::memcpy(words.data(), &value, sizeof(T));
    const std::uint64_t version = version_.load(std::memory_order_relaxed);
    version_.store(version + 1, std::memory_order_relaxed);  // odd: being written
    for (std::size_t i = 0; i < kWords; ++i) words_[i].store(words[i], std::memory_order_release);
    version_.store(version + 2, std::memory_order_release);
  }

  /// False: it was being written all the while, `value` stays as it was.
  bool read(T& value) const noexcept {
    constexpr int kTries = 16;  // a writer that is held up in the middle is not waited for
    for (int i = 0; i < kTries; ++i) {
      const std::uint64_t before = version_.load(std::memory_order_acquire);
      if (before % 2 == 1) continue;
      std::array<std::uint64_t, kWords> words;
      for (std::size_t k = 0; k < kWords; ++k) words[k] = words_[k].load(std::memory_order_acquire);
      if (version_.load(std::memory_order_relaxed) != before) continue;
      std::memcpy(static_cast<void*>(&value), words.data(), sizeof(T));
      return true;
    }
    return false;
  }

 private:
  std::array<std::atomic<std::uint64_t>, kWords> words_{};
  std::atomic<std::uint64_t> version_{0};
};

}  // namespace kt
