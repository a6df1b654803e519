#pragma once
// How fast datagrams may go, and for which loss parity is worth its bytes. A line that is too slow loses the more the
// faster one sends: parity makes that worse. What is lost by chance does not depend on the rate. Which of the two it is
// an experiment tells: sent at 0.7 of the rate, a full line loses much less, and as much arrives as before.
#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>

#include "network/channel/sealed.hpp"

namespace kt {

class RateControl {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr double kSlower = 0.7;        ///< of the rate, in an experiment
  static constexpr double kOfLine = 0.9;        ///< of what a full line lets through
  static constexpr double kFaster = 1.05;       ///< a window, once a full line has been left alone for a while
  static constexpr double kUsualWindow = 0.25;  ///< [s] at least
  static constexpr std::uint64_t kFewest = 100, kFewestInTest = 300;  ///< datagrams of a window

  /// @param told  what the receiver says; may be old, or the same again
  /// @param sent  datagrams so far
  void told(const Feedback& told, std::uint64_t sent, Time now);

  /// Datagrams a second, no more; infinity: nothing speaks against any rate.
  double limit() const { return is_testing_ ? test_limit_ : limit_; }
  /// The loss that does not depend on the rate; none: not known yet.
  std::optional<double> chance_loss() const { return chance_; }
  int num_full() const { return full_; }  ///< times that the line was found full

 private:
  /// Of some datagrams one after the other.
  struct Window {
    double loss = 0, rate = 0, arriving = 0, datagrams = 0;  ///< share, 1/s, 1/s
  };
  void look_at(const Window& window, std::uint64_t sent, Time now);
  void judge(const Window& slow, Time now);
  void grow(const Window& window, Time now);

  static constexpr double kNone = std::numeric_limits<double>::infinity();
  double limit_ = kNone, test_limit_ = kNone;
  std::optional<double> chance_;
  bool is_testing_ = false, has_begun_ = false;
  std::uint64_t from_ = 0;  ///< the window begins when this counter has come
  Feedback first_;          ///< of the window
  Time began_{};
  Window before_;  ///< the experiment
  Time alone_until_{};
  double alone_ = 2;  ///< [s] that a line found full is left at its limit
  int full_ = 0;
};

}  // namespace kt
