// The mouse, a pen or a finger in the page of kilotouch view: it moves the target of a simulated hand
// (haptics/device/moved_target.hpp), which a page's run holds in the place of this device.
#include "core/base/error.hpp"
#include "haptics/driver/find_devices.hpp"

namespace kt {

std::unique_ptr<HapticDevice> make_pointer_device(const DeviceOptions&) {
  throw InputError(
      "tool.path.device.name pointer: a page moves it; kilotouch view SCENE, or kilotouch touch ADDRESS --device "
      "pointer");
}

std::vector<FoundDevice> find_pointer_devices(const DeviceSettings&) {
  return {{.backend = "pointer",
           .id = "page",
           .name = "mouse, pen or finger, in the page of kilotouch view",
           .trouble = ""}};
}

}  // namespace kt
