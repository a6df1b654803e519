// CPU time that a device adds to a tick: its pose out of the slot, coupling, passivity and the rest of the safety
// chain, the order into the slot.
#include <benchmark/benchmark.h>

#include "haptics/driver/device_slots.hpp"
#include "haptics/guard/guarded_device.hpp"

namespace {

struct Live {
  Live() : slots(std::make_shared<kt::DeviceSlots>()) {
    reading.count = 1;
    slots->health = kt::DeviceHealth::ok;
    put(0);
    options.slots = slots;
    options.live.name = "pushed";
    options.live.origin = kt::Vec3(0, 0, 0);
  }
  void put(int tick) {
    reading.x[2] = 1e-3 * (tick % 20);
    reading.at_ns = kt::monotonic_ns();
    ++reading.count;
    ++reading.delays;
    reading.delay = 8e-4;
    slots->reading.put(reading);
  }
  std::shared_ptr<kt::DeviceSlots> slots;
  kt::DeviceReading reading;
  kt::DeviceOptions options;
};

void tick_of_a_live_device(benchmark::State& state) {
  Live live;
  kt::GuardedDevice device(kt::make_device("pushed", live.options), {.most_damping = 20});
  int tick = 0;
  for (auto _ : state) {
    live.put(tick);
    const kt::Pose tool = device.pose(1e-3 * tick, 1e-3);
    kt::LocalFrame frame;
    frame.pose = tool;
    frame.force = {0, 0, 200 * (0.02 - tool.x.z())};
    frame.normal = kt::Vec3::UnitZ();
    frame.f_n = frame.force.z();
    benchmark::DoNotOptimize(device.give(frame, 1e-3, 1e-3));
    ++tick;
  }
}
BENCHMARK(tick_of_a_live_device);

}  // namespace
