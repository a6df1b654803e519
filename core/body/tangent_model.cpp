#include "core/body/tangent_model.hpp"

#include "core/base/stages.hpp"

namespace kt {

void linearize(const DeformableModel& model, const State& state, TangentKind kind, TangentModel& out) {
  const Stage stage("linearize");
  out.state = state;
  model.force(state, out.f0);
  Tangent tangent;
  tangent.dfdx.swap(out.dfdx);  // moving a sparse matrix would copy it
  tangent.dfdv.swap(out.dfdv);
  model.update_tangent(state, kind, tangent);
  out.dfdx.swap(tangent.dfdx);
  out.dfdv.swap(tangent.dfdv);
  if (out.mass.rows() != model.mass().rows() || out.mass.nonZeros() != model.mass().nonZeros()) out.mass = model.mass();
  out.fixed_nodes = model.fixed_nodes();
}

TangentModel linearize(const DeformableModel& model, const State& state, TangentKind kind) {
  TangentModel out;
  linearize(model, state, kind, out);
  return out;
}

}  // namespace kt
