#include "lab/chart/point.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace kt {
namespace {

using Json = nlohmann::ordered_json;

constexpr ChartAxis kAxes[] = {
    {"force_error", "/truth/force_error", "force error [%]", 100, false},
    {"jnd_fraction", "/truth/jnd_fraction", "time with a noticeable error [%]", 100, false},
    {"work_error", "/truth/work_error", "error of the tool's work [%]", 100, false},
    {"penetration_um", "/penetration_max_m", "deepest penetration [µm]", 1e6, false},
    {"buzz", "/force/buzz", "buzz above 100 Hz [%]", 100, false},
    {"crossing_jump", "/force/crossing_jump", "jump at an edge [%]", 100, false},
    {"refresh_jump", "/force/refresh_jump", "jump at a refresh [%]", 100, false},
    {"tick_p50_us", "/step_us/p50", "tick, median [µs CPU]", 1, true},
    {"tick_p999_us", "/step_us/p999", "tick, 99.9 of 100 below [µs CPU]", 1, true},
    {"refresh_ms", "/cpu/refresh_ms/p50", "refresh with its global step, median [ms CPU]", 1, true},
    {"refresh_p99_ms", "/cpu/refresh_ms/p99", "refresh with its global step, 99 of 100 below [ms CPU]", 1, true},
    {"cpu_s_per_s", "/cpu/per_simulated_second", "CPU time for a simulated second [s]", 1, true},
};

Json look_up(const Json& summary, const char* pointer) {
  const Json::json_pointer at(pointer);
  return summary.is_object() && summary.contains(at) ? summary[at] : Json();
}

}  // namespace

std::span<const ChartAxis> chart_axes() { return kAxes; }

Json chart_point(const Json& row) {
  Json out;
  const Json& summary = row["result"];
  out["outcome"] = row["outcome"];
  out["trouble"] = row["trouble"];
  out["hash"] = look_up(summary, "/hash");
  out["nodes"] = look_up(summary, "/model/nodes");
  out["dof"] = look_up(summary, "/local/dof");
  out["real_time"] = look_up(summary, "/real_time/keeps");
  out["refined"] = look_up(summary, "/mesh_at_contact/refined");
  out["lost_contacts"] = look_up(summary, "/lost_contacts");
  for (const ChartAxis& axis : kAxes) {
    const Json value = look_up(summary, axis.summary);
    out[axis.key] = value.is_number() ? Json(axis.scale * value.get<double>()) : Json();
  }
  return out;
}

std::vector<bool> pareto_front(std::span<const double> cost, std::span<const double> error) {
  std::vector<std::size_t> order(cost.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::erase_if(order, [&](std::size_t i) { return !std::isfinite(cost[i]) || !std::isfinite(error[i]); });
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) {
    return cost[a] != cost[b] ? cost[a] < cost[b] : error[a] < error[b];
  });
  std::vector<bool> out(cost.size(), false);
  double least = std::numeric_limits<double>::infinity(), its_cost = least;
  for (const std::size_t i : order) {
    const bool is_twin = error[i] == least && cost[i] == its_cost;
    if (error[i] >= least && !is_twin) continue;
    out[i] = true;
    least = error[i];
    its_cost = cost[i];
  }
  return out;
}

}  // namespace kt
