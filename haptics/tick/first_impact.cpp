// What the tools meet: the first impact on their way, and the surface that they have got into unseen.
#include "collision/held/first_contact.hpp"

#include <algorithm>

#include "haptics/tick/tick_stages.hpp"

namespace kt {

std::optional<Contact> find_impact(TickState& tick, MovingTool TouchingTool::*part) noexcept {
  tick.index().refit(tick.model->work.x_event, tick.model->work.x_end);
  std::optional<Contact> first;
  for (int k = 0; k < tick.num_tools(); ++k) {
    const std::optional<Contact> of_tool = find_impact_of(tick, k, tick.tools[k].*part);
    if (of_tool && !(first && of_tool->toi >= first->toi)) first = of_tool;
  }
  return first;
}

std::optional<Contact> find_impact_of(const TickState& tick, int tool, const MovingTool& moving) noexcept {
  PreparedLocalModel& m = *tick.model;
  const MovingTriangles surface{m.surface.facets.triangles, m.work.x_event, m.work.x_end};
  auto impact = find_first_contact(tick.index(), surface, moving, m.work.ignored[tool], m.work.candidates);
  if (impact) impact->tool = tool;
  return impact;
}

int find_overlap(TickState& tick, int tool, const MovingTool& moving) noexcept {
  constexpr double kPushOut = 0.06;       // [s] a tool that was found inside is out after it,
  constexpr double kPushSpeed = 0.1;      // [m/s] or as much later as it takes at this mean speed
  constexpr double kLeastLimited = 1e-4;  // [m] a smaller overlap is a new model's difference, which the blend fades
  PreparedLocalModel& m = *tick.model;
  TouchingTool& t = tick.tools[tool];
  if (!tick.near_apron) m.surface.place_apron(m.work.motion, m.work.x);
  const SurfacePatch& facets = m.surface.facets;
  const int way_out = m.way_out[tool] < 0 ? -1 : m.local_facet(m.way_out[tool] * m.surface.facets_per_triangle());
  Contact deepest;
  deepest.gap = t.shape().radius;
  for (const Vec3& corner : moving.corners_t0()) {
    const Contact nearest = way_out < 0 ? nearest_point_contact(facets, m.work.x, corner)
                                        : track_point_contact(facets, m.work.x, corner, way_out);
    if (nearest.gap < deepest.gap) deepest = nearest;
  }
  if (deepest.triangle < 0) return -1;
  if (tick.num_tools() > 1) {  // far away on the other side of a patch that is not its own: find_contact_sites()
    const auto nodes = m.work.x.head(3 * facets.num_vertices()).reshaped(3, facets.num_vertices());
    if (-deepest.gap > (nodes.rowwise().maxCoeff() - nodes.rowwise().minCoeff()).norm()) return -1;
  }
  const double overlap = t.shape().radius - deepest.gap, time = std::max(kPushOut, overlap / kPushSpeed);
  m.state.overlap[tool] = {overlap, time, time};
  if (overlap > kLeastLimited) t.push.begin();
  return deepest.triangle;
}

}  // namespace kt
