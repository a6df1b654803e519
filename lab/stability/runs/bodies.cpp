#include "lab/stability/runs/bodies.hpp"

#include <cmath>
#include <random>

#include "core/linear/dense/dense_solvers.hpp"
#include "core/linear/free_dofs.hpp"
#include "models/fem/material.hpp"

namespace kt {

std::vector<ModelChoice> all_models() {
  std::vector<ModelChoice> out{{"msd", ""}};
  for (const BackendInfo& material : material_backends()) out.push_back({"fem", material.name});
  return out;
}

std::unique_ptr<DeformableModel> clamped(const ModelChoice& choice, Mesh mesh, ModelOptions options) {
  const Bounds box = bounds(mesh);
  for (int i = 0; i < mesh.num_nodes(); ++i)
    if (node(mesh.x, i).z() <= box.min.z() + 1e-6 * box.size().z()) options.fixed_nodes.push_back(i);
  if (!choice.material.empty()) options.material = choice.material;
  return make_model(choice.type, std::move(mesh), std::move(options));
}

VectorX shaken_positions(const DeformableModel& model, double size, unsigned seed) {
  std::mt19937_64 random(seed);
  VectorX out(model.mesh().x.size());
  for (double& value : out) value = size * (2 * (static_cast<double>(random() >> 11) * 0x1p-53) - 1);
  for (int i : model.fixed_nodes()) node(out, i).setZero();
  return out;
}

Vibration slowest_vibration(const DeformableModel& model) {
  const FreeDofs dofs = make_free_dofs(model.mesh().num_nodes(), model.fixed_nodes());
  const Tangent tangent = model.tangent(rest_state(model), TangentKind::exact);
  const EigenPairs modes = generalized_eigen(-MatrixX(gather(dofs, tangent.dfdx)), gather(dofs, model.mass()));
  Vibration out{std::sqrt(modes.values[0]), VectorX::Zero(model.mesh().x.size())};
  scatter(dofs, modes.vectors.col(0), out.shape);
  return out;
}

}  // namespace kt
