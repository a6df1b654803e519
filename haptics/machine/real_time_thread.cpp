#include "haptics/machine/real_time_thread.hpp"

#include <linux/capability.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <mutex>

#include "core/base/error.hpp"

namespace kt {
namespace {

constexpr std::size_t kStack = std::size_t{256} << 10;  // bytes: more than a tick goes down

/// What the tick's calls will use is there before.
[[gnu::noinline]] void touch_stack() noexcept {
  char stack[kStack];
  std::memset(stack, 1, sizeof stack);
  asm volatile("" : : "r"(stack) : "memory");  // it is not left out
}

/// How many threads want the process's memory locked.
std::mutex counting;
int holders = 0;
bool was_locked_before = false;

std::string status_of_process() {
  std::ifstream in("/proc/self/status");
  return {std::istreambuf_iterator<char>(in), {}};
}

long long field_kb(const std::string& status, const std::string& name) {
  const std::size_t at = status.find('\n' + name + ':');
  return at == std::string::npos ? 0 : std::atoll(status.c_str() + at + name.size() + 2);
}

/// All that is there now, at once; what comes later, when it is first used.
bool hold_memory() {
  const std::scoped_lock lock(counting);
  if (holders == 0) {
    was_locked_before = field_kb(status_of_process(), "VmLck") > 0;
    if (mlockall(MCL_CURRENT) != 0) return false;
    if (mlockall(MCL_FUTURE | MCL_ONFAULT) != 0 && !was_locked_before) {
      munlockall();
      return false;
    }
  }
  ++holders;
  return true;
}

void let_memory_go() {
  const std::scoped_lock lock(counting);
  if (--holders == 0 && !was_locked_before) munlockall();
}

long long limit_of(__rlimit_resource which) {
  rlimit limit{};
  if (getrlimit(which, &limit) != 0) return 0;
  return limit.rlim_cur == RLIM_INFINITY ? -1 : static_cast<long long>(limit.rlim_cur);
}

}  // namespace

bool has_capability(const std::string& status, int capability) {
  const std::size_t at = status.find("CapEff:");
  if (at == std::string::npos) return false;
  return (std::strtoull(status.c_str() + at + 7, nullptr, 16) >> capability & 1) != 0;
}

RealTimeLimits real_time_limits() {
  const std::string status = status_of_process();
  return {.may_schedule = has_capability(status, CAP_SYS_NICE),
          .may_lock = has_capability(status, CAP_IPC_LOCK),
          .most_priority = limit_of(RLIMIT_RTPRIO),
          .most_locked = limit_of(RLIMIT_MEMLOCK),
          .mapped = 1024 * field_kb(status, "VmSize"),
          .memory = static_cast<long long>(sysconf(_SC_PHYS_PAGES)) * sysconf(_SC_PAGESIZE)};
}

std::string why_no_lock(const RealTimeLimits& l) {
  if (!l.may_lock && l.most_locked >= 0)
    return text(
        "memory is not locked: the limit is ", l.most_locked / 1024,
        " kB (ulimit -l); put the line \"@realtime - memlock unlimited\" into /etc/security/limits.d/99-realtime.conf, "
        "add yourself to the group realtime and log in again");
  if (l.memory > 0 && l.mapped > l.memory / 2)
    return text("memory is not locked: the process maps ", l.mapped >> 20, " MB, more than half of the ",
                l.memory >> 20, " MB that there are");
  return {};
}

std::string why_no_priority(const RealTimeLimits& l) {
  if (l.may_schedule || l.most_priority != 0) return {};
  return "SCHED_FIFO is not granted: the limit of real-time priority is 0 (ulimit -r); put the line \"@realtime - "
         "rtprio 95\" "
         "into /etc/security/limits.d/99-realtime.conf, add yourself to the group realtime and log in again";
}

RealTimeThread::RealTimeThread(const RealTimeOptions& options) {
  const RealTimeLimits limits = real_time_limits();
  const auto refused = [&](const char* what, int error) {
    grant_.why_not.push_back(text(what, ": ", std::strerror(error)));
  };
  prctl(PR_SET_TIMERSLACK, 1);  // [ns] that the system may add to a sleep, else 50 us
  if (std::string why = why_no_priority(limits); !why.empty()) {
    grant_.why_not.push_back(std::move(why));
  } else {
    sched_param param{};
    param.sched_priority = std::clamp(options.priority, 1, 99);
    if (!limits.may_schedule && limits.most_priority > 0)
      param.sched_priority = std::min(param.sched_priority, static_cast<int>(limits.most_priority));
    if (const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &param); error == 0)
      grant_.priority = param.sched_priority;
    else
      refused("SCHED_FIFO is not granted", error);
  }
  if (options.core >= 0) {
    cpu_set_t cores;
    CPU_ZERO(&cores);
    CPU_SET(options.core, &cores);
    if (const int error = pthread_setaffinity_np(pthread_self(), sizeof cores, &cores); error == 0)
      grant_.core = options.core;
    else
      refused(text("core ", options.core, " is not granted").c_str(), error);
  }
  if (options.locks_memory) {
    if (std::string why = why_no_lock(limits); !why.empty())
      grant_.why_not.push_back(std::move(why));
    else if (hold_memory())
      grant_.locked = holds_memory_ = true;
    else
      refused("memory is not locked", errno);
  }
  touch_stack();
}

RealTimeThread::~RealTimeThread() {
  if (holds_memory_) let_memory_go();
}

void RealTimeThread::start() noexcept {
  rusage use{};
  getrusage(RUSAGE_THREAD, &use);
  faults_ = use.ru_minflt;
  major_faults_ = use.ru_majflt;
}

void RealTimeThread::stop() noexcept {
  rusage use{};
  if (getrusage(RUSAGE_THREAD, &use) != 0) return;
  const long major = use.ru_majflt - major_faults_;
  grant_.major_page_faults = std::max(0L, grant_.major_page_faults) + major;
  grant_.page_faults = std::max(0L, grant_.page_faults) + use.ru_minflt - faults_ + major;
}

std::string RealTimeGrant::told() const {
  std::string out = scheduler();
  if (priority > 0) out += text(' ', priority);
  out += locked ? ", memory locked" : ", memory not locked";
  out += core < 0 ? std::string(", any core") : text(", core ", core);
  if (page_faults >= 0) out += text(", ", page_faults, page_faults == 1 ? " page fault" : " page faults", " in ticks");
  if (major_page_faults > 0) out += text(" (", major_page_faults, " from the disk)");
  for (const std::string& why : why_not) out += "; " + why;
  return out;
}

}  // namespace kt
