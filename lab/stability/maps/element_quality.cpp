// One sliver in a block, thinner and thinner, x time step, by integrator and material: what it does to the explicit
// limit (which falls with it, as Lanczos says), and whether implicit steps of a body pressed hard still converge.
#include <cmath>

#include "core/base/numbers.hpp"
#include "lab/stability/map.hpp"
#include "lab/stability/runs/explicit_limit.hpp"
#include "lab/stability/runs/rays.hpp"
#include "lab/stability/runs/sliver.hpp"
#include "lab/stability/runs/step_runs.hpp"

namespace kt {
namespace {

constexpr double kCell = 0.01;  // [m]
constexpr double kYoung = 1e4;  // [Pa]

struct Ray {
  ModelChoice model;
  std::string integrator;
  double dihedral = 0;  ///< [degrees]
  std::string series() const { return integrator + " | " + model.name(); }
};

int count_inverted(const Mesh& mesh, const VectorX& x) {
  int out = 0;
  for (const Tetrahedron& t : mesh.tetrahedra) out += tetrahedron_volume(x, t) <= 0;
  return out;
}

/// A tenth of the body's stiffness, about, as a pressure on its top [N], (3n).
VectorX press(const DeformableModel& model) {
  const Mesh& mesh = model.mesh();
  VectorX out = VectorX::Zero(mesh.x.size());
  const double top = bounds(mesh).max.z();
  for (int i = 0; i < mesh.num_nodes(); ++i)
    if (node(mesh.x, i).z() > top - 1e-9) node(out, i).z() = -0.05 * kYoung * kCell * kCell;
  return out;
}

/// Some steps under the pressure, at every time step of a ladder.
RayResult implicit_ray(const Ray& ray, const DeformableModel& model) {
  constexpr int kSteps = 20;
  const VectorX load = press(model);
  RayResult out;
  for (double dt : {1e-4, 1e-3, 1e-2, 1e-1}) {
    MapPoint p = point_at(ray.series(), ray.dihedral, dt);
    const auto integrator = make_integrator(ray.integrator);
    State state = rest_state(model);
    judge_steps(p, state, [&] {
      for (int i = 0; i < kSteps; ++i) integrator->step(model, load, dt, state);
      const int inverted = count_inverted(model.mesh(), state.x), open = integrator->statistics().not_converged;
      p.value = integrator->statistics().iterations / static_cast<double>(kSteps);
      p.verdict = !state.x.allFinite() || open > 0 ? MapVerdict::fails
                  : inverted > 0                   ? MapVerdict::degrades
                                                   : MapVerdict::works;
      p.why = told(p.value, " linear systems a step; ", open, " of ", kSteps, " steps did not converge, ", inverted,
                   " elements inside out");
    });
    out.points.push_back(p);
  }
  return out;
}

}  // namespace

StabilityMap map_element_quality(const MapOptions& options) {
  StabilityMap map;
  map.x_name = "smallest dihedral angle of the sliver [degrees]";
  map.y_name = "time step [s]";
  map.x_log = map.y_log = true;
  const std::vector<double> angles =
      options.full ? std::vector<double>{0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 45} : std::vector<double>{0.1, 0.5, 2, 10, 45};
  std::vector<Ray> rays;
  for (const char* integrator : {"symplectic_euler", "implicit_euler", "newton_euler"})
    for (const ModelChoice& model : all_models())
      for (double angle : angles) rays.push_back({model, integrator, angle});
  run_rays(
      options, static_cast<int>(rays.size()),
      [&](int i) {
        const Ray& ray = rays[static_cast<std::size_t>(i)];
        const auto model = clamped(ray.model, block_with_sliver(3, kCell, ray.dihedral), {.young = kYoung});
        return ray.integrator == "symplectic_euler"
                   ? find_explicit_limit(*model, ray.integrator, ray.series(), ray.dihedral)
                   : implicit_ray(ray, *model);
      },
      map);
  map.claim = told("a sliver shortens explicit steps as far as its fastest mode says, to ",
                   100 * distance_from_theory(map, [](const std::string&) { return true; }),
                   " %; implicit steps do not feel it before it turns inside out");
  return map;
}

}  // namespace kt
