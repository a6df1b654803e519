#pragma once
// What the drivers of force devices have in common when they have read a pose.
#include <cmath>

#include "core/base/types.hpp"
#include "haptics/driver/device_slots.hpp"

namespace kt {

/// Completes a reading whose x and v are set, and puts it into its slot. An order that is written now waits for the
/// next reading's turn, so the time between two readings is told as the delay; a pause beyond 20 ms is none of the
/// loop's.
inline void put_reading(DeviceSlots& slots, DeviceReading& reading, const Quaternion& turn, unsigned buttons,
                        std::int64_t now_ns) noexcept {
  constexpr std::int64_t kPause_ns = 20'000'000;
  reading.turn[0] = turn.w();
  reading.turn[1] = turn.x();
  reading.turn[2] = turn.y();
  reading.turn[3] = turn.z();
  reading.buttons = buttons;
  if (const std::int64_t period = now_ns - reading.at_ns; reading.count > 0 && period < kPause_ns) {
    reading.delay = 1e-9 * static_cast<double>(period);
    ++reading.delays;
  }
  reading.at_ns = now_ns;
  ++reading.count;
  slots.reading.put(reading);
}

}  // namespace kt
