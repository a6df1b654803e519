// Haply Inverse3.
#include "haptics/driver/live_device.hpp"
namespace kt {
std::unique_ptr<HapticDevice> make_haply_device(const DeviceOptions& options) {
  return make_live_device(options, nullptr);
}
std::vector<FoundDevice> find_haply_devices(const DeviceSettings&) { return {}; }
}  // namespace kt
