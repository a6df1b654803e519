#include "core/body/tangent_model.hpp"

namespace kt {

void linearize(const DeformableModel& model, const State& state, TangentKind kind, TangentModel& out) {
  out.state = state;
  model.force(state, out.f0);
  Tangent tangent{std::move(out.dfdx), std::move(out.dfdv)};
  model.update_tangent(state, kind, tangent);
  out.dfdx = std::move(tangent.dfdx);
  out.dfdv = std::move(tangent.dfdv);
  if (out.mass.rows() != model.mass().rows() || out.mass.nonZeros() != model.mass().nonZeros()) out.mass = model.mass();
  out.fixed_nodes = model.fixed_nodes();
}

TangentModel linearize(const DeformableModel& model, const State& state, TangentKind kind) {
  TangentModel out;
  linearize(model, state, kind, out);
  return out;
}

}  // namespace kt
