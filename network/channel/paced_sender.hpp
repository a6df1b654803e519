#pragma once
// Sends messages of many datagrams at a pace that no queue on the way overflows from, and small ones at once.
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

namespace kt {

struct Pace {
  int datagrams = 8;  ///< at once
  std::chrono::microseconds interval{300};
};

/// That spreads so many datagrams over a time, but does not dawdle with a few.
/// @param limit  datagrams a second, no more
Pace pace_for(std::size_t datagrams, double seconds, double limit);

struct PacedCounts {
  long urgent = 0, paced = 0;  ///< payloads sent
  long replaced = 0;           ///< not sent: a newer message of their kind came
  long overflown = 0;          ///< urgent ones not sent: too many waited
};

/// A plain object: the thread that sends calls pump() when it is due. Holds payloads, not sealed datagrams: what is
/// replaced must not have used a counter (Sealer::seal), so `send` seals.
class PacedSender {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Send = std::function<void(std::span<const std::uint8_t>)>;
  static constexpr std::size_t kMostUrgent = 1024;  ///< payloads that wait; more: the oldest are dropped
  static constexpr int kMostLate = 4;               ///< intervals that a late pump() makes up for

  explicit PacedSender(const Pace& pace = {}) : pace_(pace) {}

  /// From now on.
  void set_pace(const Pace& pace) { pace_ = pace; }

  /// @param payloads  of one message; what waits of an older message of the same kind, not urgent, is dropped
  /// @param urgent    goes before all that are not, and without a pace: for small messages
  void put(std::vector<std::vector<std::uint8_t>> payloads, bool urgent, std::uint8_t kind = 0);

  /// Sends what is due.
  /// @returns time until the next is due; none: nothing waits
  std::optional<std::chrono::microseconds> pump(Time now, const Send& send);

  PacedCounts counts() const { return counts_; }
  bool is_sending(std::uint8_t kind) const { return paced_.contains(kind); }  ///< one that is not urgent
  std::size_t num_waiting() const;

 private:
  struct Waiting {
    std::vector<std::vector<std::uint8_t>> payloads;
    std::size_t sent = 0;
  };
  void send_some(const Send& send);

  Pace pace_;
  std::deque<std::vector<std::uint8_t>> urgent_;
  std::map<std::uint8_t, Waiting> paced_;  ///< by kind, the smaller first
  Time due_{};                             ///< of the next payloads that are not urgent
  bool idle_ = true;                       ///< none of these waited after the last pump()
  PacedCounts counts_;
};

}  // namespace kt
