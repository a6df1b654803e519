#include "models/model.hpp"

#include <algorithm>
#include <cmath>

namespace kt {

#define MODEL(name, available, option, what) \
  std::unique_ptr<DeformableModel> make_##name##_model(Mesh mesh, const ModelOptions& options);
#include "models/models.def"

std::vector<BackendInfo> model_backends() {
  return {
#define MODEL(name, available, option, what) {#name, what, available != 0, option},
#include "models/models.def"
  };
}

namespace {

void require_positive(const char* key, double value) {
  if (!(value > 0) || !std::isfinite(value))
    throw InputError(text("model.", key, " = ", value, ": must be a finite number > 0"));
}

void require_not_negative(const char* key, double value) {
  if (!(value >= 0) || !std::isfinite(value))
    throw InputError(text("model.", key, " = ", value, ": must be a finite number >= 0"));
}

void check(const Mesh& mesh, const ModelOptions& o) {
  require_positive("young", o.young);
  require_positive("density", o.density);
  if (!(o.poisson > -1 && o.poisson < 0.5))
    throw InputError(text("model.poisson = ", o.poisson, ": must be in (-1, 0.5)"));
  require_not_negative("damping.mass", o.damping_mass);
  require_not_negative("damping.stiffness", o.damping_stiffness);
  if (o.stiffness) require_positive("stiffness", *o.stiffness);
  if (o.damper) require_not_negative("damper", *o.damper);
  if (!(o.least_volume >= 0 && o.least_volume <= 0.95))
    throw InputError(text("model.least_volume = ", o.least_volume, ": must be in [0, 0.95]"));
  if (mesh.num_nodes() == 0 || mesh.triangles.empty()) throw InputError("model: the mesh has no surface triangles");
  if (!mesh.x.allFinite()) throw InputError("model: the mesh has a coordinate that is not a finite number");
  for (int i : o.fixed_nodes)
    if (i < 0 || i >= mesh.num_nodes())
      throw InputError(text("model: fixed node ", i, " is outside 0 .. ", mesh.num_nodes() - 1));
}

}  // namespace

std::unique_ptr<DeformableModel> make_model(const std::string& type, Mesh mesh, ModelOptions options) {
  require_backend("model", type, model_backends());
  check(mesh, options);
  std::vector<int>& fixed = options.fixed_nodes;
  std::sort(fixed.begin(), fixed.end());
  fixed.erase(std::unique(fixed.begin(), fixed.end()), fixed.end());
#define MODEL(name, available, option, what) \
  if (type == #name) return make_##name##_model(std::move(mesh), options);
#include "models/models.def"
  return nullptr;
}

}  // namespace kt
