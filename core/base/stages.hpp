#pragma once
// Where a piece of work spends its processor's time, by named stages: for benches. Nobody asks: nothing is measured.
#include <string>
#include <utility>
#include <vector>

#include "core/base/cpu_time.hpp"

namespace kt {

/// Milliseconds of this thread's CPU time by stage, a row for each piece of work that was closed. A stage within
/// another one counts in both.
class StageTimes {
 public:
  using Row = std::vector<std::pair<std::string, double>>;
  /// Those that this thread's stages are told to; none: nobody asks.
  static StageTimes*& asked() {
    thread_local StageTimes* times = nullptr;
    return times;
  }
  void add(const char* stage, double ms) {
    for (auto& [name, sum] : open_)
      if (name == stage) {
        sum += ms;
        return;
      }
    open_.emplace_back(stage, ms);
  }
  void close() { rows_.push_back(std::exchange(open_, {})); }
  /// The stages of another thread, whose work belongs to this one's.
  void take(const StageTimes& other) {
    for (const auto& [name, ms] : other.open_) add(name.c_str(), ms);
  }
  const std::vector<Row>& rows() const { return rows_; }

 private:
  Row open_;
  std::vector<Row> rows_;
};

/// From here to the end of the scope.
class Stage {
 public:
  explicit Stage(const char* name) : name_(name), start_(StageTimes::asked() ? thread_time_ms() : 0) {}
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;
  ~Stage() {
    if (StageTimes* times = StageTimes::asked()) times->add(name_, thread_time_ms() - start_);
  }

 private:
  const char* name_;
  double start_;
};

}  // namespace kt
