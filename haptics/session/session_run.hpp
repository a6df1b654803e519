#pragma once
// What drives a touch in a session: devices in, devices out, records; in lockstep or against the wall clock.
#include "haptics/driver/guarded_device.hpp"
#include "haptics/session/session.hpp"
#include "haptics/touch/body_side.hpp"
#include "haptics/touch/contact_watch.hpp"
#include "haptics/touch/touch.hpp"

namespace kt {

/// Everything a run needs, made from the session.
struct RunParts {
  const SessionOptions& options;
  int ticks = 0;
  Touch& touch;
  std::vector<GuardedDevice>& devices;
  ContactWatch* watch = nullptr;  ///< none: nobody looks
  SessionResult& result;          ///< tools with their start and room for nothing else
};

void run_lockstep(const RunParts& run);
void run_threads(const RunParts& run);

}  // namespace kt
