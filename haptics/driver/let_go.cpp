#include "haptics/driver/let_go.hpp"

#include <signal.h>
#include <time.h>

#include <atomic>

namespace kt {
namespace {

std::atomic<bool> is_let_go{false}, is_watched{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal's handler sets it");

void end_by(int signal) {
  let_go_and_wait();
  ::signal(signal, SIG_DFL);
  ::raise(signal);
}

}  // namespace

void let_go_of_devices() noexcept { is_let_go = true; }
bool are_devices_let_go() noexcept { return is_let_go.load(std::memory_order_relaxed); }

void let_go_and_wait() noexcept {
  let_go_of_devices();
  if (!is_watched) return;  // no device was ever opened
  timespec left{0, 60'000'000};
  while (::nanosleep(&left, &left) != 0) {
  }
}

void let_go_on_fatal_signals() {
  if (is_watched.exchange(true)) return;
  for (const int signal : {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL, SIGHUP, SIGQUIT}) {
    struct sigaction now {};
    if (::sigaction(signal, nullptr, &now) != 0 || now.sa_handler != SIG_DFL) continue;
    struct sigaction own {};
    own.sa_handler = end_by;
    own.sa_flags = SA_NODEFER;
    ::sigaction(signal, &own, nullptr);
  }
}

}  // namespace kt
