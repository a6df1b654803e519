#pragma once
// What a device's thread and the haptic tick exchange: the newest reading one way, the newest order the other. In the
// device's own frame, SI units; the tick's side of it is LiveDevice.
#include <atomic>
#include <cmath>
#include <limits>

#include "core/base/slot.hpp"
#include "haptics/device/haptic_device.hpp"
#include "haptics/driver/let_go.hpp"

namespace kt {

/// [ns] of the clock that never jumps.
std::int64_t monotonic_ns() noexcept;

inline bool all_finite(const double* values, int count) noexcept {
  double sum = 0;
  for (int i = 0; i < count; ++i) sum += std::abs(values[i]);
  return std::isfinite(sum);
}

/// What a device says of itself at one moment.
struct DeviceReading {
  double x[3] = {0, 0, 0};        ///< [m]
  double turn[4] = {1, 0, 0, 0};  ///< unit quaternion w x y z, from the stylus' frame to the device's
  double v[3] = {std::numeric_limits<double>::quiet_NaN(), 0, 0};  ///< the device's own [m/s]; not finite: it has none
  double delay = 0;                                                ///< from an order to its force, measured last [s]
  std::uint64_t delays = 0;                                        ///< how many were measured
  std::uint64_t buttons = 0;                                       ///< bit 0: the first
  std::int64_t at_ns = 0;                                          ///< when it was read; 0: never yet
  std::uint64_t count = 0;                                         ///< of readings so far
  double echoed =
      std::numeric_limits<double>::quiet_NaN();  ///< |force| that it repeats [N]; not finite: it repeats none
  double most_echoed = 0;                        ///< largest so far [N]

  bool is_finite() const noexcept { return all_finite(x, 3) && all_finite(turn, 4); }
};

/// What a device is to give.
struct DeviceOrder {
  double force[3] = {0, 0, 0};   ///< [N]
  double torque[3] = {0, 0, 0};  ///< [N m]
  std::int64_t at_ns = 0;        ///< when the tick wrote it
  std::uint64_t count = 0;       ///< of orders so far

  bool is_finite() const noexcept { return all_finite(force, 3) && all_finite(torque, 3); }
};

/// Shared by a driver's thread and the tick. The driver says of what health the device is.
struct DeviceSlots {
  static constexpr std::int64_t kOldestOrder_ns = 20'000'000;

  Slot<DeviceReading> reading;  ///< driver -> tick; only readings that are finite
  Slot<DeviceOrder> order;      ///< tick -> driver
  std::atomic<DeviceHealth> health{DeviceHealth::gone};

  /// What a driver writes to its device now: the newest order; nothing when the tick has stopped, or never began. This
  /// is the watchdog outside the tick: a driver's thread goes on when the tick hangs.
  DeviceOrder wanted(std::int64_t now_ns) const noexcept {
    DeviceOrder out;
    if (are_devices_let_go() || !order.read(out) || out.at_ns == 0 || now_ns - out.at_ns > kOldestOrder_ns ||
        !out.is_finite())
      return {};
    return out;
  }
};

/// A device that is open: a thread of its own, or the vendor's, keeps the slots up to date. Destroyed, it has written
/// zeros for 50 ms, whatever the order says, and has closed the device.
class DeviceDriver {
 public:
  virtual ~DeviceDriver() = default;
  /// What the device says it is. Limits of forces are the device's own, before any scaling.
  virtual DeviceInfo info() const = 0;
  /// What there is to say of it so far, a line each.
  virtual std::vector<std::string> notes() const { return {}; }
};

/// What a list of devices says of one that is there.
struct FoundDevice {
  std::string backend, id, name;
  std::string trouble;  ///< why it cannot be used; empty: it can
};

}  // namespace kt
