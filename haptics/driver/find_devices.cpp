#include "haptics/driver/find_devices.hpp"

namespace kt {

#define DEVICE(name, available, option, what)
#define LIVE_DEVICE(name, available, option, what) \
  std::vector<FoundDevice> find_##name##_devices(const DeviceSettings&);
#include "haptics/device/device.def"
#define KT_FIND_IF_1(name) return find_##name##_devices(settings);
#define KT_FIND_IF_0(name) return {};
#define KT_FIND_IF(available, name) KT_FIND_IF_(available, name)
#define KT_FIND_IF_(available, name) KT_FIND_IF_##available(name)

std::vector<FoundDevice> find_devices(const std::string& name, const DeviceSettings& settings) {
#define DEVICE(known, available, option, what)
#define LIVE_DEVICE(known, available, option, what) \
  if (name == #known) {                             \
    KT_FIND_IF(available, known)                    \
  }
#include "haptics/device/device.def"
  return {};
}

std::string calibration_advice(const std::string& name) {
  if (name == "haply") return "put its grip on the inkwell and wait until its light is steady";
  if (name == "openhaptics") return "put the stylus into the inkwell and leave it there until it is calibrated";
  if (name == "forcedimension") return "put the pole of the device into its calibration pit";
  return {};
}

void throw_which_device(const std::string& name, const std::string& id, const std::vector<std::string>& ids) {
  if (id.empty())
    throw InputError(text("tool.path.device: ", name, ": several are connected (", join(ids),
                          "); name one in tool.path.device.id (--id)"));
  throw InputError(
      text("tool.path.device.id \"", id, "\": no such ", name, " device; found: ", ids.empty() ? "none" : join(ids)));
}

}  // namespace kt
