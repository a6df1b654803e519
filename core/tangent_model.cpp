#include "core/tangent_model.hpp"

namespace kt {

TangentModel linearize(const DeformableModel& model, const State& state, TangentKind kind) {
  TangentModel out;
  out.state = state;
  model.force(state, out.f0);
  Tangent tangent = model.tangent(state, kind);
  out.dfdx = std::move(tangent.dfdx);
  out.dfdv = std::move(tangent.dfdv);
  out.mass = model.mass();
  out.fixed_nodes = model.fixed_nodes();
  return out;
}

}  // namespace kt
