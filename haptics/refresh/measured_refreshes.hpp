#pragma once
// What refreshes took, against what was predicted of them: when "auto" has to step down, and when it may step up again.
#include <vector>

#include "haptics/refresh/reducer_candidates.hpp"

namespace kt {

class MeasuredRefreshes {
 public:
  /// @param all_ms  CPU time of a refresh; own_ms: the part of it that the local model took; beside_ms: what another
  ///                core took meanwhile, which the refresh waited for
  /// @param chosen  index of the candidate that made the model
  void note(double all_ms, double own_ms, double beside_ms, const std::vector<ReducerCandidate>& candidates,
            std::size_t chosen, const ReducerNeeds& needs);

  /// The candidates with what their refreshes would take now: measured, or where one was not used yet, as much more
  /// than predicted as the others took.
  std::vector<ReducerCandidate> expected(std::vector<ReducerCandidate> candidates) const;

  bool is_overloaded() const { return over_ >= kOver; }  ///< some refreshes in a row took more than the budget
  bool has_room() const {
    return within_ >= patience_;
  }  ///< none did for long: the longer, the more often it was wrong
  void stepped_down();
  void stepped_up();
  double last_ms() const { return last_ms_; }

 private:
  static constexpr int kOver = 3, kPatience = 30, kMostPatience = 900;  // refreshes
  std::vector<double> own_ms_;                                          // running means, by candidate; 0: not known
  double rest_ms_ = 0, beside_ms_ = 0, slower_ = 0, last_ms_ = 0;
  int over_ = 0, within_ = 0, patience_ = kPatience;
  bool went_up_ = false;
};

}  // namespace kt
