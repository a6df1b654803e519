#include "haptics/refresh/refresh_pace.hpp"

#include <algorithm>
#include <cmath>

namespace kt {
namespace {

constexpr int kMostHaste = 4;
constexpr double kGaveWay = 0.15;  // of the largest force: that a local model was off
/// [N] Devices have more friction than that: an error of a smaller force counts as one of this force.
constexpr double kFelt = 0.01;
constexpr double kAlert = 0.25;  // [s] after that
constexpr double kOfTheDelay = 0.25;
constexpr double kShortestInterval = 0.008;  // [s] in which a new local model's force is back where its own balance is

}  // namespace

void RefreshPace::judge(double t, double error, double force, double tolerance) noexcept {
  most_force_ = std::max(most_force_, force);
  error *= std::min(1.0, force / kFelt);
  if (error * force > kGaveWay * most_force_) gave_way_ = t;
  if (error > tolerance)
    haste_ = std::min(2 * haste_, kMostHaste);
  else if (error < 0.5 * tolerance && t - gave_way_ > kAlert)
    haste_ = std::max(haste_ / 2, 1);
}

/// Of models on their way for long, at most four at a time: more would tell the same, and each is the slow side's work.
int RefreshPace::interval(int usual, double delay, double rate_hz) const noexcept {
  const int shortest = static_cast<int>(std::lround(std::max(kShortestInterval, kOfTheDelay * delay) * rate_hz));
  return std::max({1, usual / haste_, std::min(usual, shortest)});
}

}  // namespace kt
