#pragma once
// What the hand gives a body through the tool.
#include <algorithm>
#include <cstddef>
#include <span>

#include "haptics/tick/local_frame.hpp"

namespace kt {

struct HandWork {
  double given = 0;    ///< in all [J]
  double most = 0;     ///< at any moment up to then [J]
  double dragged = 0;  ///< between the two times [J]
};

/// @param from, to  exclusive [s]
inline HandWork hand_work(std::span<const LocalFrame> frames, double from, double to) {
  HandWork out;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const double work = -frames[i].force.dot(frames[i].pose.x - frames[i - 1].pose.x);
    out.given += work;
    out.most = std::max(out.most, out.given);
    if (frames[i].t > from && frames[i].t < to) out.dragged += work;
  }
  return out;
}

}  // namespace kt
