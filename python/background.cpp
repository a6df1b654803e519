#include "python/background.hpp"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <list>
#include <mutex>
#include <thread>

#include "core/base/error.hpp"

namespace kt {
namespace {

struct Works {
  std::mutex mutex;
  std::condition_variable changed;
  std::list<std::function<void()>> stops;  // of what runs
  std::atomic<std::thread::id> last{};     // the thread that ends Python
  std::atomic<bool> is_ending{false};
  std::atomic<int> returning{0};  // threads that take the interpreter's lock again
};

Works& works() {
  static auto* all = new Works;  // threads may look at it until the process is gone
  return *all;
}

}  // namespace

void begin_ending() noexcept {
  works().last = std::this_thread::get_id();
  works().is_ending = true;
}

NoGil::~NoGil() {
  Works& all = works();
  ++all.returning;  // before it is asked whether Python ends: see end_background()
  if (all.is_ending && std::this_thread::get_id() != all.last.load()) {
    --all.returning;
    for (;;) pause();
  }
  PyEval_RestoreThread(state_);
  --all.returning;
}

void in_background(std::function<void()> work, std::function<void()> stop) {
  Works& all = works();
  const std::scoped_lock lock(all.mutex);
  if (all.is_ending) throw RunError("Python ends: nothing is started any more");
  const auto its = all.stops.insert(all.stops.end(), std::move(stop));
  try {
    std::thread([&all, its, work = std::move(work)]() mutable {
      work();
      work = nullptr;
      const std::scoped_lock at_end(all.mutex);
      all.stops.erase(its);
      all.changed.notify_all();
    }).detach();
  } catch (const std::exception& e) {
    all.stops.erase(its);
    throw RunError(text("no thread could be started: ", e.what()));
  }
}

void end_background() {
  Works& all = works();
  constexpr std::chrono::seconds kLongest{30};
  const NoGil no_gil;
  const auto end = std::chrono::steady_clock::now() + kLongest;
  {
    std::unique_lock lock(all.mutex);
    for (const auto& stop : all.stops)
      if (stop) stop();
    all.changed.wait_until(lock, end, [&] { return all.stops.empty(); });
  }
  // A thread that waits for the interpreter already gets it now: later it would be ended within a destructor.
  while (all.returning > 0 && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

bool& was_interrupted() noexcept {
  thread_local bool interrupted = false;
  return interrupted;
}

bool& is_in_model() noexcept {
  thread_local bool in_model = false;
  return in_model;
}

}  // namespace kt
