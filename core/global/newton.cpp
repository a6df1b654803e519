#include "core/global/newton.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kt {
namespace {

constexpr int kMaxIterations = 50;
constexpr double kRoundoff = 1e-9;  // of the body's size: displacements below may stop shrinking

double size_of(const DeformableModel& model) {
  const auto points = model.mesh().x.reshaped(3, model.mesh().num_nodes());
  return (points.rowwise().maxCoeff() - points.rowwise().minCoeff()).norm();
}

/// Share of the direction that brings the slope along it near zero: the slope is that of the step's energy, which
/// forces alone do not give. Where the energy is concave it only falls: the whole direction.
template <class Slope>
double line_search(double slope_start, const Slope& slope) {
  constexpr double kEnough = 0.8;  // Crisfield 1991, section 9.4
  double low = 0, high = 1, slope_low = slope_start, slope_high = slope(1);
  for (int i = 0; i < 12; ++i) {
    if (std::isfinite(slope_high) && slope_high <= kEnough * std::abs(slope_start)) return high;
    const double share = std::isfinite(slope_high) ? slope_low / (slope_low - slope_high) : 0.5;
    const double middle = low + std::clamp(share, 0.1, 0.5) * (high - low);
    const double slope_middle = slope(middle);
    if (slope_middle < 0) {
      if (slope_middle >= -kEnough * std::abs(slope_start)) return middle;
      low = middle;
      slope_low = slope_middle;
    } else {
      high = middle;
      slope_high = slope_middle;
    }
  }
  return high;
}

}  // namespace

VectorX free_positions(const DeformableModel& model, const FreeDofs& dofs) { return gather(dofs, model.mesh().x); }

/// M (v - v_start) - a (f + external) on the free nodes; `state` is moved to v.
VectorX NewtonSolver::residual(const DeformableModel& model, const VectorX& external, const ImplicitStage& stage,
                               const VectorX& v, State& state) const {
  state.x = stage.x_start + stage.a * v;
  state.v = stage.is_static ? VectorX(VectorX::Zero(v.size())) : v;
  VectorX out;
  model.force(state, out);
  out = -stage.a * (out + external);
  if (!stage.is_static) out += model.mass() * (v - stage.v_start);
  return gather(matrix_->dofs(), out);
}

void NewtonSolver::find_direction(const DeformableModel& model, const ImplicitStage& stage, const State& state,
                                  const VectorX& residual, VectorX& direction) {
  static const SparseMatrix kNone;
  const double a = stage.a;
  for (const TangentKind kind : {TangentKind::exact, TangentKind::definite}) {
    model.update_tangent(state, kind, tangent_);
    const SparseMatrix& sum =
        stage.is_static ? matrix_->sum({{{0, &model.mass()}, {0, &kNone}, {-a * a, &tangent_.dfdx}}})
                        : matrix_->sum({{{1, &model.mass()}, {-a, &tangent_.dfdv}, {-a * a, &tangent_.dfdx}}});
    direction.setZero(residual.size());
    const bool good = solver_->solve(sum, -residual, direction);
    statistics_.linear_iterations += solver_->iterations();
    if (good && direction.allFinite() && residual.dot(direction) < 0) return;
    if (kind == TangentKind::exact) ++statistics_.projected;
  }
  throw RunError(text(stage.is_static ? "no equilibrium: the stiffness" : "implicit step: its matrix",
                      " is not positive definite, or global.solver pcg does not converge, at t = ", state.t, " s",
                      stage.is_static ? "; a body must be clamped to rest" : ""));
}

void NewtonSolver::solve(const DeformableModel& model, const VectorX& external, const ImplicitStage& stage,
                         State& state) {
  if (!matrix_) {
    matrix_ = std::make_unique<StepMatrix>(make_free_dofs(model.mesh().num_nodes(), model.fixed_nodes()));
    solver_ = make_step_solver(options_.solver, {free_positions(model, matrix_->dofs()), options_.tolerance});
  }
  if (matrix_->dofs().size() == 0) return;
  const double size = std::max(size_of(model), state.x.lpNorm<Eigen::Infinity>());
  double moved_before = std::numeric_limits<double>::infinity();
  VectorX v = state.v, full = VectorX::Zero(v.size()), direction;
  const State start = state;
  v *= model.free_share(stage.x_start, stage.a * v);
  VectorX g = residual(model, external, stage, v, state);
  for (int i = 0;; ++i) {
    if (g.squaredNorm() == 0) break;
    if (i == kMaxIterations) {
      ++statistics_.not_converged;
      break;
    }
    ++statistics_.iterations;
    find_direction(model, stage, state, g, direction);
    scatter(matrix_->dofs(), direction, full);
    const double free = model.free_share(state.x, stage.a * full);
    direction *= free;
    full *= free;
    double last = 0;
    const double share = line_search(g.dot(direction), [&](double s) {
      last = s;
      g = residual(model, external, stage, v + s * full, state);
      return g.dot(direction);
    });
    if (last != share) g = residual(model, external, stage, v + share * full, state);
    v += share * full;
    if (!g.allFinite()) throw RunError(text("implicit step: left the finite numbers at t = ", state.t, " s"));
    const double moved = share * stage.a * direction.lpNorm<Eigen::Infinity>();
    if (free < 1) continue;
    if (moved <= options_.convergence * size || (moved <= kRoundoff * size && moved > 0.9 * moved_before)) break;
    moved_before = moved;
  }
  for (int i : model.fixed_nodes()) {
    node(state.x, i) = node(start.x, i);
    node(state.v, i) = node(start.v, i);
  }
}

}  // namespace kt
