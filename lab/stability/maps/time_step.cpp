// Time step x stiffness, for every integrator on every model: where explicit steps diverge, and where implicit ones,
// which do not, damp or delay the body's slowest vibration by more than a person notices. On top the theory:
// 2/omega_max by Lanczos (with damping, its damped form), and the stability functions of the implicit integrators.
#include <cmath>
#include <numbers>

#include "core/base/numbers.hpp"
#include "core/body/state.hpp"
#include "haptics/predict/predict_time_step.hpp"
#include "lab/stability/bisect.hpp"
#include "lab/stability/map.hpp"
#include "lab/stability/runs/explicit_limit.hpp"
#include "lab/stability/runs/rays.hpp"
#include "lab/stability/runs/step_runs.hpp"

namespace kt {
namespace {

constexpr double kJnd = 0.1;       // a force that differs by less is not noticed
constexpr double kDamping = 2e-3;  // [s], the default of object.model.damping.stiffness
constexpr double kCell = 0.01;     // [m]

struct Ray {
  ModelChoice model;
  std::string integrator;
  double young = 0, damping = 0;
  std::string series() const { return integrator + (damping > 0 ? ", damped | " : " | ") + model.name(); }
};

std::unique_ptr<DeformableModel> body_of(const Ray& ray, const MapOptions& options) {
  const int n = options.full ? 5 : 3;
  return clamped(ray.model, kuhn_block(n, n, n, kCell), {.young = ray.young, .damping_stiffness = ray.damping});
}

/// Where the theory gives the JND, per omega.
double theoretical_limit(const std::string& integrator) {
  return bisect(1e-3, 2, {.tolerance = 1e-6},
                [&](double omega_h) { return theoretical_period_error(integrator, omega_h) > kJnd; })
      .at();
}

RayResult implicit_ray(const Ray& ray, const MapOptions& options) {
  const auto model = body_of(ray, options);
  const Vibration slowest = slowest_vibration(*model);
  const double period = 2 * std::numbers::pi / slowest.omega;
  const double amplitude = 1e-4 * kCell / slowest.shape.lpNorm<Eigen::Infinity>();  // small: no nonlinearity
  RayResult out;
  const auto is_off = [&](double dt) {
    constexpr int kSteps = 20;
    MapPoint p = point_at(ray.series(), ray.young, dt);
    p.predicted_failure = predict_unstable_step(*model, rest_state(*model), ray.integrator, dt).has_value();
    const auto integrator = make_integrator(ray.integrator);
    const StepRun run = run_vibration(*model, *integrator, slowest, amplitude, dt, kSteps);
    p.value = run.period_error;
    p.hash = run.hash;
    const bool bad = run.diverged(2) || !run.converged;
    p.verdict = bad ? MapVerdict::fails : run.period_error > kJnd ? MapVerdict::degrades : MapVerdict::works;
    p.why = bad ? (run.error.empty() ? "grows, or Newton's method does not converge" : run.error)
                : text("slowest vibration off by ", in_percent(run.period_error), " after a period");
    out.points.push_back(p);
    return p.verdict != MapVerdict::works;
  };
  const RayCrossing limit = bisect(period / 400, period / 5, {.tolerance = 0.01}, is_off);
  for (double periods : {1.1, 30.3}) is_off(periods * period);  // no limit of stability
  out.boundaries.push_back({ray.series(), "10 % off a period, measured", {{ray.young, limit.at()}}, false});
  out.boundaries.push_back({ray.series(),
                            "theory: 10 % off, stability function",
                            {{ray.young, theoretical_limit(ray.integrator) / slowest.omega}},
                            true});
  return out;
}

/// Without inertia there is no step to be too long: a load's equilibrium is the same at any.
RayResult static_ray(const Ray& ray, const MapOptions& options) {
  const auto model = body_of(ray, options);
  const VectorX load = shaken_positions(*model, 1e-3 * ray.young * kCell * kCell);
  RayResult out;
  for (double dt : {1e-5, 1e-3, 1e-1, 10.0}) {
    MapPoint p = point_at(ray.series(), ray.young, dt);
    const auto integrator = make_integrator(ray.integrator);
    State state = rest_state(*model);
    integrator->step(*model, load, dt, state);
    VectorX force;
    model->force(state, force);
    force += load;
    for (int i : model->fixed_nodes()) node(force, i).setZero();
    p.value = force.norm() / load.norm();
    StateHash hash;
    hash.add(state.x);
    p.hash = hash.value();
    p.verdict = integrator->statistics().not_converged > 0 || !(p.value < 1e-6) ? MapVerdict::fails : MapVerdict::works;
    p.why = told("equilibrium, residual ", p.value, " of the load; vibrations are not there at all");
    out.points.push_back(p);
  }
  return out;
}

RayResult trace(const Ray& ray, const MapOptions& options) {
  const auto integrator = make_integrator(ray.integrator);
  if (!integrator->is_dynamic()) return static_ray(ray, options);
  return std::isinf(integrator->stable_step({1, 0}))
             ? implicit_ray(ray, options)
             : find_explicit_limit(*body_of(ray, options), ray.integrator, ray.series(), ray.young);
}

std::vector<Ray> all_rays(const MapOptions& options) {
  const std::vector<double> young =
      options.full ? std::vector<double>{1e3, 1e4, 1e5, 1e6, 1e7} : std::vector<double>{1e3, 3e4, 1e6};
  std::vector<Ray> out;
  for (const BackendInfo& integrator : integrator_backends())
    for (double damping : {0.0, kDamping}) {
      if (damping > 0 && std::isinf(make_integrator(integrator.name)->stable_step({1, 0}))) continue;
      for (const ModelChoice& model : all_models())
        for (double e : young) out.push_back({model, integrator.name, e, damping});
    }
  return out;
}

}  // namespace

StabilityMap map_time_step(const MapOptions& options) {
  StabilityMap map;
  map.x_name = "Young's modulus E [Pa]";
  map.y_name = "time step [s]";
  map.x_log = map.y_log = true;
  const std::vector<Ray> rays = all_rays(options);
  run_rays(
      options, static_cast<int>(rays.size()), [&](int i) { return trace(rays[i], options); }, map);
  const auto is_explicit = [](const std::string& series) { return series.starts_with("symplectic"); };
  map.claim = told("explicit steps diverge within ", 100 * distance_from_theory(map, is_explicit),
                   " % of the theoretical limit, at the latest; implicit ones never do, and lose 10 % of the slowest "
                   "vibration's period within ",
                   100 * distance_from_theory(map, [&](const std::string& series) { return !is_explicit(series); }),
                   " % of where their stability functions say");
  return map;
}

}  // namespace kt
