#include "haptics/refresh_cost.hpp"

#include <cmath>
#include <limits>

namespace kt {

double refresh_budget_ms(const Scene& scene) {
  constexpr double kRoom = 0.8;  // of the interval: some refreshes take longer than the usual one
  if (scene.local.refresh_budget_ms) return *scene.local.refresh_budget_ms;
  return models_come_late(scene) ? kRoom * 1e3 / scene.global.rate_hz : std::numeric_limits<double>::infinity();
}

double charged_ms(const Scene& scene, double measured_ms, double predicted_ms) {
  if (scene.link.charge_refreshes == "measured") return measured_ms;
  if (scene.link.charge_refreshes == "predicted") return predicted_ms;
  return scene.link.charge_refreshes == "given" ? scene.link.refresh_ms.value_or(0) : 0;
}

int charged_ticks(const Scene& scene, double measured_ms, double predicted_ms) {
  constexpr double kRoundoff = 1e-9;
  const double ticks = 1e-3 * charged_ms(scene, measured_ms, predicted_ms) * scene.local.rate_hz;
  return static_cast<int>(std::ceil(ticks - kRoundoff));
}

Scene as_real_time(Scene scene) {
  scene.link.type = "lockstep";
  scene.link.charge_refreshes = "measured";
  scene.link.refresh_ms.reset();
  return scene;
}

}  // namespace kt
