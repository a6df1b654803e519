#include "apps/console/stop_signals.hpp"

#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <thread>

#include "apps/console/commands.hpp"
#include "haptics/driver/let_go.hpp"
#include "io/files/leftovers.hpp"

namespace kt {
namespace {

std::atomic<bool> stop{false};
std::atomic<int> received{0}, saving{0};

constexpr double kPatience = 1.5;  // [s] for what runs to look up: with what ends the process, below 2 s

sigset_t stop_signals() {
  sigset_t out;
  ::sigemptyset(&out);
  ::sigaddset(&out, SIGINT);
  ::sigaddset(&out, SIGTERM);
  // Of a terminal that is closed; whoever asks for none of it (nohup) has it ignored. Blocked, it would come all the
  // same.
  static const bool hears_hangup = [] {
    struct sigaction now {};
    return ::sigaction(SIGHUP, nullptr, &now) == 0 && now.sa_handler != SIG_IGN;
  }();
  if (hears_hangup) ::sigaddset(&out, SIGHUP);
  return out;
}

/// Waits so long for another signal.
bool came_again(const sigset_t& signals, double seconds) {
  const timespec wait{static_cast<time_t>(seconds), static_cast<long>(1e9 * (seconds - static_cast<time_t>(seconds)))};
  int signal = -1;
  do signal = ::sigtimedwait(&signals, nullptr, &wait);
  while (signal < 0 && errno == EINTR);
  return signal > 0;
}

[[noreturn]] void end_now(const std::string& note) {
  let_go_and_wait();
  remove_leftovers();  // children die with this process
  std::fprintf(stderr, "kilotouch: %s: %s\n", stop_signal_name().c_str(), note.c_str());
  ::_exit(128 + received);
}

void watch() {
  const sigset_t signals = stop_signals();
  int signal = 0;
  while (::sigwait(&signals, &signal) != 0) {
  }
  received = signal;
  stop = true;
  const char* const lost = "ended at the second signal; what was not yet written is lost";
  for (bool is_told = false;; is_told = true) {
    if (came_again(signals, kPatience)) end_now(lost);
    if (saving == 0) break;
    if (!is_told)
      std::fprintf(
          stderr,
          "kilotouch: %s: what was recorded is written when the step under way has ended; a second signal ends "
          "at once, without it\n",
          stop_signal_name().c_str());
    while (saving > 0)
      if (came_again(signals, 0.05)) end_now(lost);
  }  // and again: what has written its results needs time to end, too
  end_now("ended within a step; nothing of it is kept, files that were there before are as they were");
}

}  // namespace

void request_stop() { stop = true; }

const std::atomic<bool>& stop_requested() { return stop; }

void watch_stop_signals() {
  const sigset_t signals = stop_signals();
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);  // threads made later inherit it
  std::thread(watch).detach();
}

int stop_signal() { return received; }

std::string stop_signal_name() {
  if (received == SIGHUP) return "SIGHUP (the terminal was closed)";
  return received == SIGINT ? "SIGINT (Ctrl-C)" : "SIGTERM";
}

SavingResults::SavingResults() { ++saving; }
SavingResults::~SavingResults() { --saving; }

}  // namespace kt
