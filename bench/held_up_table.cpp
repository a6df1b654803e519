// A loop of one's own at 1 kHz on scenes/organ_springs.json, the body in its thread, whose refresh at 0.5 s is held up:
// what the hand gets meanwhile. Against the wall clock: run it on a machine that has nothing else to do.
//   build/release/bench/held_up_table [SCENE]
#include <chrono>
#include <cstdio>
#include <thread>

#include "core/base/cpu_time.hpp"
#include "haptics/halves/body_side.hpp"
#include "haptics/halves/haptic_side.hpp"
#include "haptics/session/metrics.hpp"
#include "haptics/session/session.hpp"
#include "haptics/touch/touch.hpp"
#include "haptics/touch/touch_halves.hpp"
#include "haptics/watch/contact_watch.hpp"
#include "tests/support/held_up_model.hpp"

namespace kt {
namespace {

void run(const Session& session, int held_ms) {
  auto model = std::make_unique<HeldUpModel>(session.model());
  HeldUpModel& held = *model;
  const Body body(std::move(model));
  TouchOptions options = session.options();
  options.tools[0].max_speed = std::numeric_limits<double>::infinity();  // a hand's: not known
  Touch touch(body, options);
  ContactWatch watch(body.surface(), session.tools(), true);
  TouchHalves::observe(touch, &watch);
  const auto pose = [&](int tick) { return Pose{interpolate_path(session.path(), tick * touch.h())}; };
  touch.place(pose(0));
  touch.start();
  const int ticks = static_cast<int>(session.scene().duration / touch.h());
  std::vector<double> force, us;
  int stale = 0;
  auto due = std::chrono::steady_clock::now();
  for (int i = 0; i < ticks; ++i) {
    std::this_thread::sleep_until(due += std::chrono::milliseconds(1));
    if (i == 500) held.hold_ms = held_ms;
    const Pose next = pose(i + 1);
    const double start = thread_time_us();
    const LocalFrame& f = touch.tick(next);
    us.push_back(thread_time_us() - start);
    watch.ticked(TouchHalves::fast(touch), {&f, 1});
    force.push_back(f.force.norm());
    stale += (f.flags & kStaleModel) != 0;
  }
  touch.stop();
  watch.finish(TouchHalves::fast(touch).model());
  double mean = 0, step = 0;
  int zero = 0, at = 0;
  for (int i = 400; i < ticks; ++i) {
    mean += force[i] / (ticks - 400);
    zero += force[i] == 0;
    if (std::abs(force[i] - force[i - 1]) <= step) continue;
    step = std::abs(force[i] - force[i - 1]);
    at = i;
  }
  std::printf("%7d %9d %8d %8d %9.4f %9.2f %7d %6d %8.1f %8.1f\n", held_ms, touch.status().refreshes,
              watch.lost(0).free_ticks_inside, zero, mean, 100 * step / mean, at, stale, percentile(us, 0.5),
              percentile(us, 0.99));
  std::fflush(stdout);
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  const std::string file = argc > 1 ? argv[1] : KT_SOURCE_DIR "/scenes/organ_springs.json";
  const kt::Session session(kt::load_scene(file));
  std::printf("held ms refreshes  inside  no force  mean N  step %%  at tick  stale  tick us  p99 us\n");
  for (const int ms : {0, 100, 500, 1000}) kt::run(session, ms);
}
