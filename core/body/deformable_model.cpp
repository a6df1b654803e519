#include "core/body/deformable_model.hpp"

#include "core/body/difference_tangent.hpp"

namespace kt {

void DeformableModel::update_tangent(const State& state, TangentKind kind, Tangent& out) const {
  difference_tangent(*this, state, kind, out);
}

}  // namespace kt
