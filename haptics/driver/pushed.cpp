// Poses from the program around the engine, forces back to it: the slots themselves, which that program fills.
#include "haptics/driver/live_device.hpp"

namespace kt {
namespace {

class Pushed final : public DeviceDriver {
 public:
  DeviceInfo info() const override {
    return {.gives_torque = true, .senses_turn = true, .name = "the program around the engine"};
  }
};

std::unique_ptr<DeviceDriver> open_pushed(const DeviceSettings&, DeviceSlots&) { return std::make_unique<Pushed>(); }

}  // namespace

std::unique_ptr<HapticDevice> make_pushed_device(const DeviceOptions& options) {
  if (!options.slots)
    throw InputError(
        "tool.path.device.name pushed: nobody pushes; it is for programs that embed the engine and give "
        "SessionOptions::pushed");
  return make_live_device(options, open_pushed);
}

std::vector<FoundDevice> find_pushed_devices(const DeviceSettings&) { return {}; }

}  // namespace kt
