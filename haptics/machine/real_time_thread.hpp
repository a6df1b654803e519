#pragma once
// A thread that must be on time: first in line for the processor, its memory there, its faults counted. Each as far as
// the system grants it, and in words where not.
#include <string>
#include <vector>

namespace kt {

struct RealTimeOptions {
  int priority = 50;         ///< of SCHED_FIFO, 1 to 99; less where the system's limit is less
  bool locks_memory = true;  ///< of the whole process
  int core = -1;             ///< the only one that it runs on; -1: any
};

/// What was granted.
struct RealTimeGrant {
  int priority = 0;                  ///< of SCHED_FIFO; 0: an ordinary thread
  bool locked = false;               ///< memory of the process
  int core = -1;                     ///< that it is kept to; -1: any
  long page_faults = -1;             ///< between start() and stop(); -1: not counted
  long major_page_faults = -1;       ///< of those, that waited for the disk
  std::vector<std::string> why_not;  ///< each thing that was not granted, and what grants it

  std::string scheduler() const { return priority > 0 ? "SCHED_FIFO" : "SCHED_OTHER"; }
  /// One sentence: "SCHED_FIFO 50, memory locked, any core, 0 page faults in ticks".
  std::string told() const;
};

/// Of the thread that makes it and destroys it; the memory stays locked as long as any of them is there. Takes some
/// tens of milliseconds: the memory of the process is fetched. Nothing of it changes what is computed.
/// SCHED_DEADLINE is not asked for: it stops a thread whose tick takes longer than was announced, and what a tick takes
/// is not known before (man 7 sched).
class RealTimeThread {
 public:
  explicit RealTimeThread(const RealTimeOptions& options = {});
  ~RealTimeThread();
  RealTimeThread(const RealTimeThread&) = delete;
  RealTimeThread& operator=(const RealTimeThread&) = delete;

  void start() noexcept;  ///< page faults count from here
  void stop() noexcept;   ///< and until here; of several times, together. No allocation
  const RealTimeGrant& grant() const { return grant_; }

 private:
  RealTimeGrant grant_;
  long faults_ = 0, major_faults_ = 0;
  bool holds_memory_ = false;
};

/// What a process may do, as the system says it; for the words and for tests.
struct RealTimeLimits {
  bool may_schedule = false;                     ///< CAP_SYS_NICE
  bool may_lock = false;                         ///< CAP_IPC_LOCK
  long long most_priority = 0, most_locked = 0;  ///< RLIMIT_RTPRIO; RLIMIT_MEMLOCK [bytes], -1: no limit
  long long mapped = 0, memory = 0;              ///< by this process; of the machine [bytes]
};

RealTimeLimits real_time_limits();

/// Of the effective capabilities in /proc/self/status. False where there is no such line.
bool has_capability(const std::string& status, int capability);

/// Empty: the process's memory may be locked. Else the reason and the cure. A limit is none to try: what is allocated
/// later would then fail.
std::string why_no_lock(const RealTimeLimits& limits);
std::string why_no_priority(const RealTimeLimits& limits);

}  // namespace kt
