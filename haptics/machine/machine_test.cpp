#include "haptics/machine/machine_test.hpp"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <thread>

#include "core/base/error.hpp"
#include "core/base/percentile.hpp"

namespace kt {
namespace {

constexpr double kMostRate = 1e5, kMostSeconds = 600;

long long now_ns() noexcept {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return 1000000000LL * now.tv_sec + now.tv_nsec;
}

/// Sleeps as the haptic thread does, as often as there is room in `late` [us]. No allocation.
/// @returns how often it woke up
std::size_t wake_up(double rate_hz, std::span<double> late, const std::atomic<bool>* stop) noexcept {
  const long long start = now_ns();
  std::size_t i = 0;
  for (; i < late.size() && !(stop && *stop); ++i) {
    const long long due = start + std::llround(1e9 * static_cast<double>(i + 1) / rate_hz);
    const timespec at{static_cast<time_t>(due / 1000000000), static_cast<long>(due % 1000000000)};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr) != 0) {
    }
    late[i] = 1e-3 * static_cast<double>(now_ns() - due);
  }
  return i;
}

/// Work for every core, with memory that no cache holds.
class BusyLoad {
 public:
  explicit BusyLoad(bool busy) {
    const unsigned count = busy ? std::max(1u, std::thread::hardware_concurrency()) : 0;
    for (unsigned i = 0; i < count; ++i)
      threads_.emplace_back([this] {
        std::vector<unsigned> memory(1u << 22, 1u);  // 16 MB
        for (std::size_t k = 0; !done_.load(std::memory_order_relaxed); k = (k + 4099) % memory.size())
          memory[k] = memory[k] * 1664525u + 1013904223u;
      });
  }
  ~BusyLoad() {
    done_ = true;
    for (std::thread& thread : threads_) thread.join();
  }
  BusyLoad(const BusyLoad&) = delete;
  BusyLoad& operator=(const BusyLoad&) = delete;

 private:
  std::atomic<bool> done_{false};
  std::vector<std::thread> threads_;
};

}  // namespace

const char* name_of(RateKept kept) {
  return kept == RateKept::yes ? "yes" : kept == RateKept::no ? "no" : "just about";
}

WakeUps judge_wake_ups(double rate_hz, const std::vector<double>& lateness_us) {
  constexpr double kGood = 0.25, kEnough = 0.5;  // of the period: the tick's own work is to fit into the rest
  WakeUps out{.rate_hz = rate_hz, .count = static_cast<int>(lateness_us.size())};
  if (lateness_us.empty()) return out;
  const double period = 1e6 / rate_hz;
  out.p50_us = percentile(lateness_us, 0.5);
  out.p99_us = percentile(lateness_us, 0.99);
  out.p999_us = percentile(lateness_us, 0.999);
  out.max_us = *std::ranges::max_element(lateness_us);
  out.over_period = static_cast<int>(std::ranges::count_if(lateness_us, [&](double us) { return us > period; }));
  if (out.p999_us <= kEnough * period) out.kept = RateKept::just_about;
  if (out.p999_us <= kGood * period && out.over_period == 0) out.kept = RateKept::yes;
  return out;
}

double MachineReport::fastest_kept_hz() const {
  double out = 0;
  for (const WakeUps& w : rates)
    if (w.kept != RateKept::no) out = std::max(out, w.rate_hz);
  return out;
}

MachineReport test_machine(const MachineTestOptions& options) {
  for (const double rate : options.rates_hz)
    if (!(rate > 0 && rate <= kMostRate))
      throw InputError(text("rate: ", rate, " Hz, must be in (0, ", kMostRate, "]"));
  if (!(options.seconds > 0 && options.seconds <= kMostSeconds))
    throw InputError(text("seconds: ", options.seconds, ", must be in (0, ", kMostSeconds, "]"));
  MachineReport out;
  out.busy = options.busy;
  const BusyLoad load(options.busy);
  std::thread([&] {
    RealTimeThread on_time(options.thread);
    for (const double rate : options.rates_hz) {
      if (options.stop && *options.stop) break;
      std::vector<double> late(static_cast<std::size_t>(std::max(1LL, std::llround(rate * options.seconds))), 0.0);
      on_time.start();
      late.resize(wake_up(rate, late, options.stop));
      on_time.stop();
      out.rates.push_back(judge_wake_ups(rate, late));
    }
    out.grant = on_time.grant();
  }).join();
  out.findings = find_hindrances(read_machine_files());
  return out;
}

}  // namespace kt
