#include "core/body/deformable_model.hpp"

#include "core/body/difference_tangent.hpp"
#include "core/body/embedded_surface.hpp"
#include "core/body/node_weights.hpp"

namespace kt {

void DeformableModel::update_tangent(const State& state, TangentKind kind, Tangent& out) const {
  difference_tangent(*this, state, kind, out);
}

State own_part(const DeformableModel& model, const State& state) {
  const Eigen::Index own = 3 * static_cast<Eigen::Index>(model.mesh().num_own_nodes());
  if (own == state.x.size()) return state;
  return {state.t, state.x.head(own), state.v.head(own)};
}

std::vector<int> still_nodes(const DeformableModel& model) {
  const auto& embedded = model.mesh().embedded;
  if (!embedded) return model.fixed_nodes();
  std::vector<char> is_fixed(static_cast<std::size_t>(embedded->first), 0);
  std::vector<int> out;
  for (const int i : model.fixed_nodes())
    if (i < embedded->first) {
      is_fixed[static_cast<std::size_t>(i)] = 1;
      out.push_back(i);
    }
  for (int v = 0; v < embedded->num_vertices(); ++v) {
    const NodeWeights its = embedded->carried_by(v);
    const bool is_still = std::all_of(its.node.begin(), its.node.begin() + its.count,
                                      [&](int i) { return is_fixed[static_cast<std::size_t>(i)] != 0; });
    if (is_still) out.push_back(embedded->first + v);
  }
  return out;
}

}  // namespace kt
