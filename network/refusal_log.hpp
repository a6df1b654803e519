#pragma once
#include <chrono>
#include <functional>
#include <string>

#include "core/base/error.hpp"
#include "core/base/visible_text.hpp"

namespace kt {

/// Lines about those who were not let in, as others word them: one line each, and no more than a few a minute, so that
/// nobody fills a log by asking.
class RefusalLog {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr double kAtOnce = 8, kPerSecond = 0.2;  ///< lines
  explicit RefusalLog(std::function<void(const std::string&)> say) : say_(std::move(say)) {}

  void add(const std::string& who, const std::string& why, Time now) {
    if (last_ != Time{})
      room_ = std::min(kAtOnce, room_ + kPerSecond * std::chrono::duration<double>(now - last_).count());
    last_ = now;
    if (room_ < 1) {
      ++untold_;
      return;
    }
    room_ -= 1;
    say_(one_line(text(who, " refused: ", why, untold_ > 0 ? text("; and ", untold_, " more refusals before") : "")));
    untold_ = 0;
  }

 private:
  std::function<void(const std::string&)> say_;
  double room_ = kAtOnce;
  long untold_ = 0;
  Time last_{};
};

}  // namespace kt
