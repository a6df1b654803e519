#include "haptics/refresh/measured_refreshes.hpp"

#include <algorithm>

namespace kt {
namespace {

constexpr double kNew = 0.3;      // of a running mean
constexpr double kForget = 0.01;  // a refresh, of how much more than now a candidate took that is not in use

void mean(double& old, double value) { old = old > 0 ? (1 - kNew) * old + kNew * value : value; }

}  // namespace

void MeasuredRefreshes::note(double all_ms, double own_ms, double beside_ms,
                             const std::vector<ReducerCandidate>& candidates, std::size_t chosen,
                             const ReducerNeeds& needs) {
  own_ms_.resize(candidates.size(), 0);
  last_ms_ = all_ms;
  mean(rest_ms_, std::max(0.0, all_ms - std::max(own_ms, beside_ms)));
  mean(beside_ms_, beside_ms);
  mean(own_ms_[chosen], own_ms);
  if (const double predicted = candidates[chosen].own_ms; predicted > 0) mean(slower_, own_ms / predicted);
  // Downwards only, so that it is tried again: that it has become dearer it would show itself, and where the prediction
  // of what is in use was too low, that says nothing about the others.
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (const double now = slower_ * candidates[i].own_ms; i != chosen && own_ms_[i] > now)
      own_ms_[i] += kForget * (now - own_ms_[i]);
  const bool is_over = all_ms > needs.refresh_budget_ms;
  over_ = is_over ? over_ + 1 : 0;
  within_ = is_over ? 0 : within_ + 1;
  if (went_up_ && within_ > patience_) went_up_ = false;  // it was right
}

std::vector<ReducerCandidate> MeasuredRefreshes::expected(std::vector<ReducerCandidate> candidates) const {
  if (!(slower_ > 0)) return candidates;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const bool is_known = i < own_ms_.size() && own_ms_[i] > 0;
    candidates[i].own_ms = is_known ? own_ms_[i] : slower_ * candidates[i].own_ms;
    candidates[i].refresh_ms = rest_ms_ + std::max(candidates[i].own_ms, beside_ms_);
  }
  return candidates;
}

void MeasuredRefreshes::stepped_down() {
  if (went_up_) patience_ = std::min(2 * patience_, kMostPatience);
  went_up_ = false;
  over_ = within_ = 0;
}

void MeasuredRefreshes::stepped_up() {
  went_up_ = true;
  over_ = within_ = 0;
}

}  // namespace kt
