#include "haptics/tick/haptic_method.hpp"

#include "haptics/tick/local_simulation.hpp"

namespace kt {

#define HAPTIC_METHOD(name, available, option, what) \
  std::unique_ptr<HapticMethod> make_##name##_method(const HapticMethodOptions& options);
#include "haptics/tick/haptic_method.def"
#undef HAPTIC_METHOD

// A baseline that is not in this build must not be asked for by the linker.
#define KT_MAKE_IF_1(method) return make_##method##_method(options);
#define KT_MAKE_IF_0(method)
#define KT_MAKE_IF_(available, method) KT_MAKE_IF_##available(method)
#define KT_MAKE_IF(available, method) KT_MAKE_IF_(available, method)

std::unique_ptr<HapticMethod> make_multirate_method(const HapticMethodOptions& options) {
  return std::make_unique<LocalSimulation>(
      options.tools, options.h, make_contact_solver(options.law, options.friction, options.friction_of_triangle),
      options.blend);
}

void HapticMethod::step_tools(std::span<const ToolSweep> sweeps, std::span<LocalFrame> frames) noexcept {
  frames[0] = step(sweeps[0]);
}

std::vector<BackendInfo> haptic_method_backends() {
  return {
#define HAPTIC_METHOD(name, available, option, what) {#name, what, available != 0, option},
#include "haptics/tick/haptic_method.def"
#undef HAPTIC_METHOD
  };
}

std::unique_ptr<HapticMethod> make_haptic_method(const std::string& name, const HapticMethodOptions& options) {
  require_backend("local.method", name, haptic_method_backends());
#define HAPTIC_METHOD(method, available, option, what) \
  if (name == #method) {                               \
    KT_MAKE_IF(available, method)                      \
  }
#include "haptics/tick/haptic_method.def"
#undef HAPTIC_METHOD
  return nullptr;
}

}  // namespace kt
