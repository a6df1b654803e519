#include "haptics/tick/haptic_method.hpp"

#include "haptics/tick/local_simulation.hpp"

namespace kt {

#define HAPTIC_METHOD(name, available, option, what) \
  std::unique_ptr<HapticMethod> make_##name##_method(const HapticMethodOptions& options);
#include "haptics/tick/haptic_method.def"
#undef HAPTIC_METHOD

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

std::vector<BackendInfo> contact_laws() {
  std::vector<BackendInfo> out = contact_solver_backends();
  out.push_back({"penalty",
                 "spring and damper to a proxy on the surface, with friction: the same as local.method penalty", true,
                 ""});
  return out;
}

std::string haptic_method_name(const std::string& method, const std::string& law) {
  require_backend("local.method", method, haptic_method_backends());
  if (law != "penalty" || method == "penalty") return method;
  if (method == "multirate") return "penalty";
  throw InputError(text("contact.law \"penalty\" is a method of its own; local.method \"", method,
                        "\" needs contact.law \"coulomb\", or leave local.method out"));
}

std::unique_ptr<HapticMethod> make_haptic_method(const std::string& name, const HapticMethodOptions& options) {
  require_backend("local.method", name, haptic_method_backends());
#define HAPTIC_METHOD(method, available, option, what) \
  if (name == #method) return make_##method##_method(options);
#include "haptics/tick/haptic_method.def"
#undef HAPTIC_METHOD
  return nullptr;
}

}  // namespace kt
