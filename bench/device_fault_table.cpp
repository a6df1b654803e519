// What devices get when something breaks: stand-ins of their libraries, the engine's drivers and its safety chain.
//   device_fault_table      prints device x fault -> largest force, largest change from one period to the next, ms
//   until
//                           the device got a zero that stayed, ms from the fault's end until it got a force again
// Times are the clock's: on a busy computer a tick comes late, and the last columns say how late, and how long the
// device was silent until then.
#include <cstdio>

#include "tests/fakes/fault_run.hpp"

int main() {
  std::puts("device          fault          force [N]  step [N]  zero [ms]  again [ms]  late tick [ms]  silent [ms]");
  for (const char* backend : {"openhaptics", "forcedimension"})
    for (const kt::fake::FaultCase& c : kt::fake::kFaultCases) {
      const kt::fake::FaultResult r = kt::fake::run_fault(backend, c, {});
      std::printf("%-15s %-14s %9.3f %9.3f %10.1f %11.1f %15.1f %12.1f%s%s\n", backend, c.name, r.most_force,
                  r.most_step, c.shuts_for(backend) ? r.zero_ms : NAN, r.back_ms, r.late_ms, r.silent_ms,
                  r.was_finite ? "" : "  NOT FINITE", r.were_zeros_last ? "" : "  NO ZEROS AT THE END");
      std::fflush(stdout);
    }
}
