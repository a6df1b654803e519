#pragma once
// Whether this computer keeps a haptic rate: how late a thread wakes up that asks for as much as the haptic thread
// does.
#include <atomic>
#include <vector>

#include "haptics/machine/machine_findings.hpp"
#include "haptics/machine/real_time_thread.hpp"

namespace kt {

struct MachineTestOptions {
  std::vector<double> rates_hz{1000, 4000, 8000};  ///< each in (0, 1e5]
  double seconds = 3;                              ///< for each rate, (0, 600]
  bool busy = false;                               ///< every core has other work meanwhile
  RealTimeOptions thread{};
  const std::atomic<bool>* stop = nullptr;  ///< Ctrl-C: what was measured so far is told
};

/// yes: of 1000 wake-ups 999 leave three quarters of the period, and each comes before the next is due; just_about: 999
/// leave a half.
enum class RateKept { yes, just_about, no };
const char* name_of(RateKept kept);

/// At one rate.
struct WakeUps {
  double rate_hz = 0;
  int count = 0;                                           ///< of wake-ups
  double p50_us = 0, p99_us = 0, p999_us = 0, max_us = 0;  ///< after they were due
  int over_period = 0;                                     ///< later than a whole period
  RateKept kept = RateKept::no;
};

struct MachineReport {
  std::vector<WakeUps> rates;
  bool busy = false;
  RealTimeGrant grant;                   ///< of the thread that was measured
  std::vector<MachineFinding> findings;  ///< what stands in the way, or could be better
  double fastest_kept_hz() const;        ///< yes or just about; 0: none
};

/// @param lateness_us  of each wake-up
WakeUps judge_wake_ups(double rate_hz, const std::vector<double>& lateness_us);

/// Takes seconds * rates. Throws InputError for rates or times out of range.
MachineReport test_machine(const MachineTestOptions& options = {});

}  // namespace kt
