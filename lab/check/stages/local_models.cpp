// Local models at several places of the surface, each with its certificate.
#include <cmath>

#include "core/base/error.hpp"
#include "haptics/refresh/reducer_choice.hpp"
#include "lab/check/mesh_work.hpp"
#include "lab/study/reference.hpp"

namespace kt {
namespace {

constexpr double kTolerance = 0.05, kBudget = 200;  // wanted: error of the impedance; CPU time of a tick [us]
constexpr double kReach = 0.009;  // of the tool until the next refresh: 1.5 radii and 40 mm/s for 1/30 s [m]

}  // namespace

void check_local_models(MeshWork& work, StageResult& out) {
  const std::size_t places = std::min<std::size_t>(work.options.quick ? 1 : 4, work.spots.size());
  for (CheckBody& body : work.bodies) {
    const DeformableModel& model = body.session->model();
    const Surface& surface = body.session->surface();
    const DeformableModel& own = model.own();
    const TangentModel tangent = linearize(own, rest_state(own), TangentKind::exact);
    double worst = 0, tick = 0;
    nlohmann::ordered_json reducers = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < places; ++i) {
      const ContactSpot& spot = work.spots[i];
      const ContactSite site{spot.place, spot.triangle, kReach};
      const SurfacePatch patch = make_patch(surface, model.mesh().x, site);
      ReducerChoice choice("auto", 1, {.tolerance = kTolerance, .budget_us = kBudget});
      choice.set_up(tangent, patch, site);
      const ReducerCandidate& c = choice.chosen();
      reducers.push_back({{"reducer", c.name}, {"dof", c.dof}, {"error", c.error}, {"predicted_us", c.tick_us}});
      if (!std::isfinite(c.error)) {
        out.lower(Verdict::fail, text(body.model, ": no local model can be certified"), work.in_file(spot.place));
        continue;
      }
      worst = std::max(worst, c.error);
      tick = std::max(tick, c.tick_us);
      if (c.error > kNoticeableForce || c.tick_us > kBudget)
        out.lower(Verdict::degraded, text(body.model, ": ", choice.reason()), work.in_file(spot.place));
    }
    out.figures[body.model] = {{"worst_error", worst}, {"predicted_us", tick}, {"places", reducers}};
  }
}

}  // namespace kt
