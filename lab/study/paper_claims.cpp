#include "lab/study/paper_claims.hpp"

#include <algorithm>

namespace kt {

double share_above_normal(std::span<const LocalFrame> frames, double from) {
  constexpr double kPresses = 0.1;
  double sum = 0;
  int touching = 0, pressing = 0, above = 0;
  for (const LocalFrame& f : frames)
    if (f.t > from && f.f_n > 0) {
      sum += f.f_n;
      ++touching;
    }
  for (const LocalFrame& f : frames)
    if (f.t > from && touching > 0 && f.f_n > kPresses * sum / touching) {
      ++pressing;
      above += f.f_t > f.f_n;
    }
  return pressing > 0 ? static_cast<double>(above) / pressing : 0;
}

double largest_slip_drop(std::span<const LocalFrame> frames, double from) {
  constexpr std::size_t kTicks = 10;
  double out = 0;
  std::size_t stuck = 0;  // ticks in a row, up to this one
  for (std::size_t i = 1; i < frames.size(); ++i) {
    stuck = frames[i - 1].mode == ContactMode::stick ? stuck + 1 : 0;
    if (frames[i].t < from || stuck < kTicks || frames[i].mode != ContactMode::frictional_slide) continue;
    const double before = frames[i - 1].f_t;
    double least = before;
    for (std::size_t k = i; k < std::min(i + kTicks, frames.size()); ++k) least = std::min(least, frames[k].f_t);
    if (before > 0) out = std::max(out, 1 - least / before);
  }
  return out;
}

int stick_to_slip(std::span<const LocalFrame> frames) {
  int count = 0;
  for (std::size_t i = 1; i < frames.size(); ++i)
    count += frames[i - 1].mode == ContactMode::stick && frames[i].mode == ContactMode::frictional_slide;
  return count;
}

}  // namespace kt
