#pragma once
// How much the normal force of a drag waves.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "haptics/tick/local_frame.hpp"

namespace kt {

struct DragRipple {
  double mean = 0;          ///< [N]
  double peak_to_peak = 0;  ///< over the mean [-]
  double largest_step = 0;  ///< from one tick to the next, over the mean [-]
};

/// From tick `from` >= 1 on, which exists.
inline DragRipple drag_ripple(std::span<const LocalFrame> frames, std::size_t from) {
  double least = frames[from].f_n, most = least, step = 0, sum = 0;
  for (std::size_t i = from; i < frames.size(); ++i) {
    least = std::min(least, frames[i].f_n);
    most = std::max(most, frames[i].f_n);
    step = std::max(step, std::abs(frames[i].f_n - frames[i - 1].f_n));
    sum += frames[i].f_n;
  }
  const double mean = sum / static_cast<double>(frames.size() - from);
  return {mean, (most - least) / mean, step / mean};
}

}  // namespace kt
