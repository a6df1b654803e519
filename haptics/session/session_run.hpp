#pragma once
// What drives a touch in a session: devices in, devices out, records; in lockstep or against the wall clock.
#include "haptics/guard/guarded_device.hpp"
#include "haptics/halves/body_side.hpp"
#include "haptics/session/session.hpp"
#include "haptics/touch/touch.hpp"
#include "haptics/watch/contact_watch.hpp"

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
