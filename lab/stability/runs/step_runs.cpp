#include "lab/stability/runs/step_runs.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include "core/body/state.hpp"

namespace kt {
namespace {

using Complex = std::complex<double>;
constexpr double kPeriod = 2 * std::numbers::pi;

/// Of the factor exp(`log_factor`) that one step of a vibration makes, taken over a period, or a step if that is
/// longer.
double error_of(const Complex& log_factor, double omega_h) {
  const double steps = std::max(1.0, kPeriod / omega_h);
  return std::abs(std::exp(log_factor * steps) - std::exp(Complex(0, -omega_h * steps)));
}

std::uint64_t hash_of(const State& state) {
  StateHash hash;
  hash.add(state.x);
  hash.add(state.v);
  return hash.value();
}

}  // namespace

StepRun run_steps(const DeformableModel& model, Integrator& integrator, State state, double dt, int steps,
                  double limit) {
  StepRun out;
  const VectorX& rest = model.mesh().x;
  const VectorX none = VectorX::Zero(rest.size());
  const double first = (state.x - rest).lpNorm<Eigen::Infinity>();
  try {
    for (; out.steps < steps && out.growth <= limit; ++out.steps) {
      integrator.step(model, none, dt, state);
      const double size = (state.x - rest).lpNorm<Eigen::Infinity>() / first;
      out.growth = state.x.allFinite() ? std::max(out.growth, size) : std::numeric_limits<double>::infinity();
    }
  } catch (const RunError& e) {
    out.error = e.what();
  }
  out.converged = integrator.statistics().not_converged == 0;
  out.hash = hash_of(state);
  return out;
}

void judge_growth(const StepRun& run, double limit, MapPoint& point) {
  const bool bad = run.diverged(limit);
  point.value = run.growth;
  point.hash = run.hash;
  point.verdict = bad ? MapVerdict::fails : MapVerdict::works;
  point.why = bad ? text("grows ", limit, " times within ", run.steps, " steps")
                  : text("stays below ", run.growth, " times its start for ", run.steps, " steps");
}

StepRun run_vibration(const DeformableModel& model, Integrator& integrator, const Vibration& vibration,
                      double amplitude, double dt, int steps) {
  StepRun out;
  State state = rest_state(model);
  state.x += amplitude * vibration.shape;
  const VectorX none = VectorX::Zero(state.x.size());
  const VectorX weights = model.mass() * vibration.shape / amplitude;
  Complex before = 1, log_factor = 0;
  try {
    for (; out.steps < steps; ++out.steps) {
      integrator.step(model, none, dt, state);
      if (!state.x.allFinite()) {
        out.growth = std::numeric_limits<double>::infinity();
        break;
      }
      const Complex now(weights.dot(state.x - model.mesh().x), weights.dot(state.v) / vibration.omega);
      if (std::abs(now) < 1e-3) break;  // what is left is roundoff and what the linear vibration does not hold
      log_factor += std::log(now / before);
      before = now;
      out.growth = std::max(out.growth, std::abs(now));
    }
  } catch (const RunError& e) {
    out.error = e.what();
  }
  out.period_error = out.steps > 0 ? error_of(log_factor / static_cast<double>(out.steps), vibration.omega * dt) : 1;
  out.converged = integrator.statistics().not_converged == 0;
  out.hash = hash_of(state);
  return out;
}

double theoretical_period_error(const std::string& integrator, double omega_h) {
  const Complex z(0, -omega_h);
  Complex R;
  if (integrator == "implicit_euler" || integrator == "newton_euler") {
    R = 1.0 / (1.0 - z);
  } else if (integrator == "implicit_midpoint") {
    R = (1.0 + z / 2.0) / (1.0 - z / 2.0);
  } else if (integrator == "sdirk2") {
    const double g = 1 - std::sqrt(0.5);
    R = (1.0 + (1 - 2 * g) * z) / ((1.0 - g * z) * (1.0 - g * z));
  } else {
    return std::numeric_limits<double>::quiet_NaN();
  }
  return error_of(std::log(R), omega_h);
}

}  // namespace kt
