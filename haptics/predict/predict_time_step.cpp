#include "haptics/predict/predict_time_step.hpp"

#include <cmath>

#include "haptics/setup/built_scene.hpp"

namespace kt {

std::optional<Prediction> predict_unstable_step(const FastestMode& mode, const std::string& integrator, double dt,
                                                const std::string& setting) {
  const double limit = make_integrator(integrator)->stable_step(mode);
  if (!(dt > limit)) return {};
  return Prediction{
      "time_step",
      Finding{told(setting, " ", integrator, ": a step of ", 1e3 * dt, " ms diverges, the body's fastest mode (",
                   mode.omega, " rad/s, damping ratio ", mode.zeta, ") allows ", 1e3 * limit, " ms"),
              {set_to(setting, "implicit_euler"), advise(told("step at ", std::ceil(1 / limit), " Hz or more"))}}
          .at(setting, dt, limit)};
}

std::optional<Prediction> predict_unstable_step(const DeformableModel& model, const State& state,
                                                const std::string& integrator, double dt, const std::string& setting) {
  if (std::isinf(make_integrator(integrator)->stable_step({1, 0}))) return {};  // at any step: no mode is looked for
  return predict_unstable_step(fastest_mode(model, state), integrator, dt, setting);
}

/// The global side keeps within the limit by itself (GlobalSimulation); the haptic tick's step is what the scene says.
/// Its local models are pieces or projections of the body: none is faster than the body itself.
void predict_time_step(const BuiltScene& built, std::vector<Prediction>& out) {
  const LocalSettings& local = built.scene().local;
  if (local.integrator != "symplectic_euler") return;
  if (auto p =
          predict_unstable_step(built.model(), built.start(), local.integrator, 1 / local.rate_hz, "local.integrator"))
    out.push_back(std::move(*p));
}

}  // namespace kt
