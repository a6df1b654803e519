#include "haptics/safety/quantized_velocity.hpp"

#include <algorithm>

namespace kt {

void QuantizedVelocity::put(const Vec3& x, double dt) noexcept {
  const double t = count_ > 0 ? t_[newest_] + std::max(dt, 0.0) : 0;
  newest_ = (newest_ + 1) % kRoom;
  x_[newest_] = x;
  t_[newest_] = t;
  count_ = std::min(count_ + 1, kRoom);
}

bool QuantizedVelocity::is_straight(int ticks) const noexcept {
  const Vec3& end = x_[newest_];
  const double t = t_[newest_] - t_[back(ticks)];
  const Vec3 way = end - x_[back(ticks)];
  for (int i = 1; i < ticks; ++i) {
    const double share = (t_[newest_] - t_[back(i)]) / t;
    if ((x_[back(i)] - (end - share * way)).lpNorm<Eigen::Infinity>() > step_ * (1 + 1e-9)) return false;
  }
  return true;
}

int QuantizedVelocity::window(double fine) const noexcept {
  constexpr double kRoundoff = 1 + 1e-9;
  int ticks = std::min(1, count_ - 1);
  while (ticks > 0 && ticks + 1 < count_) {
    const double t = t_[newest_] - t_[back(ticks)];
    if (t > 0 && step_ <= fine * t * kRoundoff) break;
    if (t_[newest_] > t_[back(ticks + 1)] && !is_straight(ticks + 1)) break;
    ++ticks;
  }
  return ticks;
}

Vec3 QuantizedVelocity::velocity(double fine) const noexcept {
  const int ticks = window(fine);
  if (ticks < 1) return Vec3::Zero();
  const double t = t_[newest_] - t_[back(ticks)];
  return t > 0 ? Vec3((x_[newest_] - x_[back(ticks)]) / t) : Vec3(Vec3::Zero());
}

}  // namespace kt
