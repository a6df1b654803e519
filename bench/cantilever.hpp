#pragma once
// The cantilever that docs/accuracy_and_speed.md measures on: 0.1 x 0.1 x 0.4 m along z, clamped at z = 0, weight along
// -x.
#include "models/model.hpp"

namespace kt {

/// `cells` cubes across, 4 * cells along.
inline std::unique_ptr<DeformableModel> cantilever(int cells, ModelOptions options) {
  Mesh mesh = kuhn_block(cells, cells, 4 * cells, 0.1 / cells);
  for (int i = 0; i < (cells + 1) * (cells + 1); ++i) options.fixed_nodes.push_back(i);
  options.gravity = Vec3(-9.81, 0, 0);
  return make_model("fem", std::move(mesh), options);
}

/// Of the middle of the free end, along x [m].
inline double tip_deflection(const DeformableModel& model, const State& state) {
  const VectorX& rest = model.mesh().x;
  int tip = 0;
  for (int i = 0; i < model.mesh().num_nodes(); ++i)
    if ((node(rest, i) - Vec3(0.05, 0.05, 0.4)).norm() < (node(rest, tip) - Vec3(0.05, 0.05, 0.4)).norm()) tip = i;
  return state.x[3 * tip] - rest[3 * tip];
}

}  // namespace kt
