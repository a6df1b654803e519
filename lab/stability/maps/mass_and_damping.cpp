// Ratio of masses within a body x its damping, at steps of 1 ms. The upper half of a block is heavier or lighter than
// the lower one, as a tool that moves with the tissue is, or a layer of another density. Explicit steps: light parts
// are fast, and dampers that are strong over a light part throw it back and forth; the line is where the damped limit
// of the fastest mode (Lanczos) is 1 ms. Implicit steps: the conjugate gradients, whose system is less even the larger
// the ratio.
#include <algorithm>
#include <cmath>

#include "core/base/numbers.hpp"
#include "haptics/predict/predict_time_step.hpp"
#include "lab/stability/bisect.hpp"
#include "lab/stability/map.hpp"
#include "lab/stability/runs/explicit_limit.hpp"
#include "lab/stability/runs/rays.hpp"
#include "lab/stability/runs/step_runs.hpp"
#include "lab/stability/runs/uneven_mass.hpp"

namespace kt {
namespace {

constexpr double kStep = 1e-3;                             // [s]
constexpr double kCell = 0.01;                             // [m]
constexpr double kLeastDamping = 1e-6, kMostDamping = 10;  // [s]

struct Ray {
  ModelChoice model;
  std::string integrator, solver = "direct";
  double ratio = 1;
  std::string series() const { return integrator + (solver == "pcg" ? ", pcg | " : " | ") + model.name(); }
};

std::unique_ptr<DeformableModel> block(const Ray& ray, double damping, const MapOptions& options) {
  const int n = options.full ? 5 : 3;
  return clamped(ray.model, kuhn_block(n, n, n, kCell), {.young = 1e4, .damping_stiffness = damping});
}

double explicit_limit(const Ray& ray, double damping, const MapOptions& options) {
  const auto block_model = block(ray, damping, options);
  const UnevenMass body(*block_model, ray.ratio);
  return make_integrator(ray.integrator)->stable_step(fastest_mode(body, rest_state(body)));
}

RayResult explicit_ray(const Ray& ray, const MapOptions& options) {
  constexpr double kGrowth = 1e3;
  constexpr int kSteps = 2000;
  RayResult out;
  const auto fails = [&](double damping) {
    const auto block_model = block(ray, damping, options);
    const UnevenMass body(*block_model, ray.ratio);
    MapPoint p = point_at(ray.series(), ray.ratio, damping,
                          predict_unstable_step(body, rest_state(body), ray.integrator, kStep));
    State start = rest_state(body);
    start.x += shaken_positions(body, 1e-6 * kCell);
    const auto integrator = make_integrator(ray.integrator);
    const StepRun run = run_steps(body, *integrator, start, kStep, kSteps, kGrowth);
    judge_growth(run, kGrowth, p);
    out.points.push_back(p);
    return p.verdict == MapVerdict::fails;
  };
  const double measured = bisect(kLeastDamping, kMostDamping, {.tolerance = 0.005}, fails).at();
  const double theory = bisect(kLeastDamping, kMostDamping, {.tolerance = 1e-4}, [&](double damping) {
                          return explicit_limit(ray, damping, options) < kStep;
                        }).at();
  out.boundaries.push_back({ray.series(), "limit of damping, measured", {{ray.ratio, measured}}, false});
  out.boundaries.push_back(
      {ray.series(), "theory: damped limit of the fastest mode is 1 ms", {{ray.ratio, theory}}, true});
  return out;
}

/// Against the direct solver: how far off the body is after some steps of a load that is let go.
RayResult implicit_ray(const Ray& ray, const MapOptions& options) {
  constexpr int kSteps = 20;
  RayResult out;
  for (double damping : {1e-6, 1e-4, 1e-2, 1.0}) {
    const auto block_model = block(ray, damping, options);
    const UnevenMass body(*block_model, ray.ratio);
    State start = rest_state(body);
    start.x += shaken_positions(body, 0.01 * kCell);
    State exact = start, state = start;
    const auto direct = make_integrator(ray.integrator, {.solver = "direct"});
    const auto tested = make_integrator(ray.integrator, {.solver = ray.solver});
    MapPoint p = point_at(ray.series(), ray.ratio, damping);
    const VectorX none = VectorX::Zero(start.x.size());
    judge_steps(p, state, [&] {
      for (int i = 0; i < kSteps; ++i) {
        direct->step(body, none, kStep, exact);
        tested->step(body, none, kStep, state);
      }
      p.value = (state.x - exact.x).norm() / (exact.x - body.mesh().x).norm();
      const double growth = (state.x - body.mesh().x).norm() / (start.x - body.mesh().x).norm();
      p.verdict = !(growth < 10) ? MapVerdict::fails : p.value > 0.1 ? MapVerdict::degrades : MapVerdict::works;
      p.why = told("off by ", in_percent(p.value), " from the direct solver, ",
                   tested->statistics().linear_iterations / kSteps, " iterations a step");
    });
    out.points.push_back(p);
  }
  return out;
}

std::vector<Ray> all_rays(const MapOptions& options) {
  std::vector<double> ratios;
  for (int k = -4; k <= 4; k += options.full ? 1 : 2) ratios.push_back(std::pow(10, k));
  std::vector<Ray> out;
  for (const ModelChoice& model : {ModelChoice{"msd", ""}, ModelChoice{"fem", "neo_hookean"}})
    for (double ratio : ratios) {
      out.push_back({model, "symplectic_euler", "direct", ratio});
      out.push_back({model, "implicit_euler", "direct", ratio});
      out.push_back({model, "implicit_euler", "pcg", ratio});
    }
  std::ranges::stable_sort(out, {}, &Ray::series);
  return out;
}

}  // namespace

StabilityMap map_mass_and_damping(const MapOptions& options) {
  StabilityMap map;
  map.x_name = "density of the upper half over that of the lower [-]";
  map.y_name = "damping by stiffness β [s]";
  map.x_log = map.y_log = true;
  const std::vector<Ray> rays = all_rays(options);
  run_rays(
      options, static_cast<int>(rays.size()),
      [&](int i) {
        const Ray& ray = rays[static_cast<std::size_t>(i)];
        return ray.integrator == "symplectic_euler" ? explicit_ray(ray, options) : implicit_ray(ray, options);
      },
      map);
  const double off = distance_from_theory(map, [](const std::string&) { return true; });
  map.claim = told(
      "steps of 1 ms: explicit ones bear less damping the lighter a part is, and none at all below some "
      "mass; the limit is within ",
      in_percent(off), " of the theory's. Implicit steps bear every ratio");
  return map;
}

}  // namespace kt
