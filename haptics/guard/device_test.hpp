#pragma once
// A device tried without a body: it presses on a soft wall, and everything is measured on the way.
#include <atomic>
#include <functional>
#include <vector>

#include "haptics/guard/safety_chain.hpp"

namespace kt {

struct DeviceTestOptions {
  double seconds = 10;
  double h = 1e-3;              ///< tick [s]
  double wall_stiffness = 200;  ///< [N/m] at the device's scale
  double wall_below = 0.01;     ///< [m] under where the device is when the test begins, world's z
  SafetyOptions safety{};       ///< its device and h are filled in
  const std::atomic<bool>* stop = nullptr;
  std::function<void(double t, const Pose&, const DeviceState&, double force, double gate)>
      progress{};  ///< twice a second
};

/// Sorted lists; times in seconds.
struct DeviceTest {
  double seconds = 0;
  int ticks = 0;
  std::vector<double> pose_age;    ///< at each tick
  std::vector<double> delay;       ///< from an order to its force, as the device told
  std::vector<double> lateness;    ///< of the ticks
  double there = 0;                ///< [s] for which the device was healthy
  double readings_per_s = 0;       ///< fresh poses, of that time
  std::vector<std::string> notes;  ///< of the device's driver
  SafetyCounts safety;
  GateReason gate = GateReason::open;            ///< at the end
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  ///< that it was moved through [m]
  unsigned buttons = 0;                          ///< that were pressed
  double deepest = 0;                            ///< in the wall [m]
  double ripple = 0;                             ///< of the force at rest in the wall, share; NaN: never at rest
  double given = 0;                              ///< most energy that the hand was given [J]
};

/// @param device  open; borrowed
DeviceTest test_device(HapticDevice& device, const DeviceTestOptions& options);

/// Of a sorted list, share in [0, 1]; NaN of an empty one.
double sorted_percentile(const std::vector<double>& sorted, double share);

}  // namespace kt
