#include "haptics/refresh/refresh_cost.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kt {

double tick_budget_us(const TouchOptions& options) {
  constexpr double kRoom = 0.8;  // of the period: the rest is for the ticks that take longer than the usual one
  return std::min(options.local.budget_us, kRoom * 1e6 / options.local.rate_hz);
}

double refresh_budget_ms(const TouchOptions& options) {
  constexpr double kRoom = 0.8;  // of the interval: some refreshes take longer than the usual one
  if (options.local.refresh_budget_ms) return *options.local.refresh_budget_ms;
  return models_come_late(options) ? kRoom * 1e3 / options.global.rate_hz : std::numeric_limits<double>::infinity();
}

double charged_ms(const TouchOptions& options, double measured_ms, double predicted_ms) {
  if (options.link.charge_refreshes == "measured") return measured_ms;
  if (options.link.charge_refreshes == "predicted") return predicted_ms;
  return options.link.charge_refreshes == "given" ? options.link.refresh_ms.value_or(0) : 0;
}

int charged_ticks(const TouchOptions& options, double measured_ms, double predicted_ms) {
  constexpr double kRoundoff = 1e-9;
  const double ticks = 1e-3 * charged_ms(options, measured_ms, predicted_ms) * options.local.rate_hz;
  return static_cast<int>(std::ceil(ticks - kRoundoff));
}

Scene as_real_time(Scene scene) {
  scene.link.type = "lockstep";
  scene.link.charge_refreshes = "measured";
  scene.link.refresh_ms.reset();
  return scene;
}

}  // namespace kt
