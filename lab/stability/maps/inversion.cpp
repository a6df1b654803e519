// How far a block is crushed x time step, by material: let go, does it come back? Beyond zero height it is inside out.
// St. Venant-Kirchhoff's energy is that of Green's strain, the same for a stretch and its mirror image: a body crushed
// through zero stays there.
#include <cmath>

#include "core/base/numbers.hpp"
#include "core/global/integrator.hpp"
#include "haptics/predict/predict_elements.hpp"
#include "lab/stability/bisect.hpp"
#include "lab/stability/map.hpp"
#include "lab/stability/runs/bodies.hpp"
#include "lab/stability/runs/rays.hpp"
#include "lab/stability/runs/step_runs.hpp"

namespace kt {
namespace {

constexpr double kCell = 0.01;     // [m]
constexpr int kCells = 3;          // a side
constexpr double kMostTime = 4.0;  // [s]

/// Scaled in height, with a little noise: a perfect inversion is a balance on a needle.
State crushed(const DeformableModel& model, double share) {
  State out = rest_state(model);
  for (int i = 0; i < model.mesh().num_nodes(); ++i) node(out.x, i).z() *= share;
  out.x += shaken_positions(model, 0.01 * kCell);
  return out;
}

MapPoint release(const ModelChoice& choice, double share, double dt) {
  const auto model =
      clamped(choice, kuhn_block(kCells, kCells, kCells, kCell), {.damping_mass = 5, .damping_stiffness = 2e-3});
  MapPoint p = point_at(choice.name(), share, dt, predict_collapse(choice.name(), share));
  const auto integrator = make_integrator("newton_euler", {.solver = "direct"});
  State state = crushed(*model, share);
  const VectorX none = VectorX::Zero(state.x.size());
  const auto off = [&] { return (state.x - model->mesh().x).lpNorm<Eigen::Infinity>() / (kCells * kCell); };
  judge_steps(p, state, [&] {
    while (state.t < kMostTime && off() > 1e-3) integrator->step(*model, none, dt, state);
    int inverted = 0;
    for (const Tetrahedron& t : model->mesh().tetrahedra) inverted += tetrahedron_volume(state.x, t) <= 0;
    p.value = off();
    p.verdict = inverted > 0 || !(p.value < 0.1) ? MapVerdict::fails
                : p.value > 1e-3                 ? MapVerdict::degrades
                                                 : MapVerdict::works;
    p.why =
        told("after ", state.t, " s off by ", in_percent(p.value), " of its edge, ", inverted, " elements inside out");
  });
  return p;
}

}  // namespace

StabilityMap map_inversion(const MapOptions& options) {
  StabilityMap map;
  map.x_name = "height it is crushed to, over its height (below 0: inside out) [-]";
  map.y_name = "time step [s]";
  map.y_log = true;
  const std::vector<double> steps =
      options.full ? std::vector<double>{3e-3, 1e-2, 3e-2, 1e-1} : std::vector<double>{5e-3, 1e-2, 3e-2};
  std::vector<ModelChoice> materials = all_models();
  const auto count = static_cast<int>(materials.size() * steps.size());
  run_rays(
      options, count,
      [&](int i) {
        const ModelChoice& choice = materials[static_cast<std::size_t>(i) / steps.size()];
        const double dt = steps[static_cast<std::size_t>(i) % steps.size()];
        RayResult out;
        const auto stays = [&](double share) {
          out.points.push_back(release(choice, share, dt));
          return out.points.back().verdict == MapVerdict::fails;
        };
        for (double share : {0.5, 0.2, -0.2, -0.5}) stays(share);
        const RayCrossing c = bisect(0.9, -0.9, {.tolerance = 0.02, .geometric = false}, stays);
        out.boundaries.push_back({choice.name(), "does not come back, measured", {{c.at(), dt}}, false});
        return out;
      },
      map);
  std::string lost;
  for (const ModelChoice& choice : materials) {
    double worst = -1;  // the least crushed that stays
    for (const MapPoint& p : map.points)
      if (p.series == choice.name() && p.verdict == MapVerdict::fails) worst = std::max(worst, p.x);
    if (worst > -1) lost += text(lost.empty() ? "" : ", ", choice.name(), " below ", worst);
  }
  map.claim = "let go, bodies come back from any crushing, inside out too" +
              (lost.empty() ? std::string() : ", but for " + lost + " of their height");
  return map;
}

}  // namespace kt
