#pragma once
// What drives a touch in a session: devices in, devices out, records; in lockstep or against the wall clock.
#include "haptics/device/passivity.hpp"
#include "haptics/session/contact_watch.hpp"
#include "haptics/session/session.hpp"
#include "haptics/touch/body_side.hpp"
#include "haptics/touch/touch.hpp"

namespace kt {

/// A device at its tool: what it is given, and the energy between them.
class HandAtDevice {
 public:
  /// @param most_damping  that passivity control may add [N s/m]
  HandAtDevice(std::unique_ptr<HapticDevice> device, double most_damping, double h);
  Pose pose(double t) noexcept { return device_->pose(t); }
  /// Writes what the device can give of the frame's force, and puts that in the frame. Returns the model's force.
  Vec3 give(LocalFrame& frame, double h) noexcept;
  int limited_forces() const { return limited_; }
  std::optional<PassivityRun> energy() const;

 private:
  std::unique_ptr<HapticDevice> device_;
  DeviceInfo info_;
  std::optional<PassivityControl> passivity_;  // of a device that moves with the force
  int limited_ = 0;
};

/// Everything a run needs, made from the session.
struct RunParts {
  const SessionOptions& options;
  int ticks = 0;
  Touch& touch;
  std::vector<HandAtDevice>& hands;
  ContactWatch* watch = nullptr;  ///< none: nobody looks
  SessionResult& result;          ///< tools with their start and room for nothing else
};

void run_lockstep(const RunParts& run);
void run_threads(const RunParts& run);

}  // namespace kt
