#include "haptics/guard/device_identify.hpp"

#include <cmath>
#include <vector>

#include "haptics/driver/device_slots.hpp"
#include "haptics/guard/sleep_until.hpp"
#include "haptics/machine/real_time_thread.hpp"

namespace kt {

DeviceFit identify_device(HapticDevice& device, const IdentifyOptions& options) {
  SafetyOptions safety = options.safety;
  safety.device = device.info();
  safety.h = options.h;
  safety.most_damping = 0;
  safety.coupling = 0;
  if (!safety.device.gives_force) return {.refusal = "it gives no force: there is no loop to be kept from swinging"};
  SafetyChain chain(safety);
  const RealTimeThread on_time;
  const double scale = safety.scale;
  const auto place = [&](const Pose& pose) { return pose.x[options.axis] / scale; };
  double rest = place(device.pose(0));
  std::vector<ReleaseSample> samples;
  const auto before = static_cast<int>(std::lround((SafetyChain::kOpening + 0.2) / options.h));
  const auto ticks = before + static_cast<int>(std::lround(options.seconds / options.h));
  const std::int64_t began = monotonic_ns(), period = std::llround(1e9 * options.h);
  std::int64_t last = began - period;
  for (int i = 0; i < ticks; ++i) {
    if (options.stop && options.stop->load()) return {.refusal = "stopped before its end"};
    if (i == before) rest += options.jump;
    sleep_until_ns(began + i * period);
    const std::int64_t now = monotonic_ns();
    const Pose at = device.pose(1e-9 * static_cast<double>(now - began));
    LocalFrame frame;
    frame.force[options.axis] = -kReleaseStiffness * (place(at) - rest) / safety.force_scale;
    const Wrench given = chain.make_safe(frame, at, device.state(), 1e-9 * static_cast<double>(now - last));
    last = now;
    device.write(given, options.h);
    if (i >= before) {
      if (chain.gate() < 1) return {.refusal = std::string("no full force: ") + name_of(chain.reason())};
      samples.push_back({1e-9 * static_cast<double>(now - began), place(at), given.force[options.axis]});
    }
  }
  return fit_release(samples, safety.device.encoder_step);
}

}  // namespace kt
