#pragma once
// Ctrl-C, SIGTERM and SIGHUP. One thread waits for them; all others have them blocked, so that no library's own handler
// (METIS sets one while it orders a matrix) can take them away. What runs looks at stop_requested() between its steps
// and ends in order, with what it has. What does not look up in time is ended, with nothing half on the disk.
#include <string>

namespace kt {

/// To be called first in main, while there is one thread.
void watch_stop_signals();

/// The signal that asked for the end, or 0.
int stop_signal();

/// "SIGINT (Ctrl-C)".
std::string stop_signal_name();

/// While one of these lives there is what would be lost: ticks that were recorded, results that are being written. They
/// are waited for, until a second signal.
class SavingResults {
 public:
  SavingResults();
  ~SavingResults();
  SavingResults(const SavingResults&) = delete;
  SavingResults& operator=(const SavingResults&) = delete;
};

}  // namespace kt
