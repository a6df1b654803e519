#include "haptics/tick/coulomb_tick.hpp"

#include <algorithm>

#include "haptics/tick/coulomb_stages.hpp"
#include "haptics/tick/tick_stages.hpp"

namespace kt {
namespace {

constexpr double kShortest = 1e-6;  // of the tick: an impact this near to the end waits for the next one

/// A session may begin with the tool inside; one may run off the patch and get in there; and the slow side looks.
bool may_be_inside(const TickState& tick, int tool) noexcept {
  const int way_out = tick.model->way_out[tool];
  const bool is_first = tick.t < 1.5 * tick.h;
  return tick.tools[tool].is_off_patch || way_out >= 0 || (is_first && way_out == kNotLooked);
}

/// Where each tool touches at the start of the tick.
void find_held_tools(TickState& tick) noexcept {
  PreparedLocalModel& m = *tick.model;
  LocalWorkspace& w = m.work;
  for (int k = 0; k < tick.num_tools(); ++k) {
    TouchingTool& tool = tick.tools[k];
    std::ranges::fill(w.ignored[k], 0);
    const auto held = std::ranges::find(m.state.anchors, k, &Contact::tool);
    tool.start = held == m.state.anchors.end() ? -1 : held->triangle;
    const bool sees_more = tick.has_new_patch || m.wide_index;
    if (tool.start < 0 && ((tool.is_off_patch && sees_more) || (tick.has_new_patch && may_be_inside(tick, k)))) {
      tool.start = find_overlap(tick, k, tool.whole);
      tool.is_off_patch = false;
    }
    double& left = m.state.overlap[k].left;
    left = std::max(0.0, left - tick.h);
  }
  tick.has_new_patch = false;
  tick.toi = 0;
  w.impulse.setZero();
  w.impulse_weighted.setZero();
  w.x_event = w.x;
}

/// Body and tools at the time of impact; what was held until then has acted until then.
/// @param part  of the tools' sweeps that the impact was found on
void rewind_to(TickState& tick, const Contact& impact, MovingTool TouchingTool::*part,
               std::span<LocalFrame> frames) noexcept {
  LocalWorkspace& w = tick.model->work;
  TouchingTool& hit = tick.tools[impact.tool];
  LocalFrame& frame = frames[impact.tool];
  w.x_event += impact.toi * (w.x_end - w.x_event);
  for (TouchingTool& tool : tick.tools) tool.rest.move(rest_of((tool.*part).sweep(), impact.toi));
  const double advanced = impact.toi * (1 - tick.toi);
  w.impulse_weighted += advanced * w.impulse;
  tick.toi += advanced;
  if (hit.start < 0) frame.toi = tick.toi;
  hit.start = impact.triangle;
  ++frame.events;
}

/// Free motion up to the first impact, if there is one.
bool fly_to_impact(TickState& tick, std::span<LocalFrame> frames) noexcept {
  LocalWorkspace& w = tick.model->work;
  follow(tick, w.u_free, w.u);
  w.x_end = w.x + tick.h * w.u;
  const std::optional<Contact> impact = find_impact(tick, &TouchingTool::whole);
  if (!impact) return false;
  rewind_to(tick, *impact, &TouchingTool::whole, frames);
  w.du.setZero();
  return true;
}

/// The solver holds these as constraints of the tool: no collision pairs.
void ignore_around(PreparedLocalModel& m, int tool, int triangle) noexcept {
  const SurfacePatch& facets = m.surface.facets;
  for (int v : facets.triangles[triangle])
    for (int t : facets.topology.triangles_of(v)) m.work.ignored[tool][t] = 1;
}

/// With contact: hold it for the rest of the tick; what else is hit on the way ends the hold early.
void hold_contacts(TickState& tick, std::span<LocalFrame> frames) noexcept {
  PreparedLocalModel& m = *tick.model;
  for (bool is_held = false;; is_held = true) {
    if (1 - tick.toi < kShortest) {
      if (tick.num_tools() == 1 || !is_held) tick.contacts.count = 0;  // else the other hand's go on
      m.work.x_end = m.work.x_event;
      return;
    }
    for (int k = 0; k < tick.num_tools(); ++k)
      if (tick.tools[k].start >= 0) ignore_around(m, k, tick.tools[k].start);
    resolve_contacts(tick);
    for (const Contact& contact : tick.contacts) ignore_around(m, contact.tool, contact.triangle);
    if (is_nothing_left_to_hit(tick)) return;
    const std::optional<Contact> impact = find_impact(tick, &TouchingTool::rest);
    if (!impact) return;
    int events = 0;
    for (int k = 0; k < tick.num_tools(); ++k) events += frames[k].events;
    if (events == kMaxEvents) return tick.add_flag(kEventsExhausted);
    rewind_to(tick, *impact, &TouchingTool::rest, frames);
  }
}

/// q+ = q + h v_free + sum of what each impulse moved, and the velocity that goes with it; a fine patch yields alike.
void advance_body(TickState& tick) noexcept {
  PreparedLocalModel& m = *tick.model;
  LocalWorkspace& w = m.work;
  LocalState& s = m.state;
  const MatrixX &Y = m.dynamics->metric().Y, &C = m.dynamics->metric().C, &Y_end = m.dynamics->end_response();
  w.impulse_weighted += (1 - tick.toi) * w.impulse;
  s.q.noalias() += tick.h * w.v_free;
  s.q_rate = w.v_free_end;
  w.patch_motion += tick.h * w.u_free.head(w.patch_motion.size());
  if (m.surface.fine) {
    m.add_yield(w.impulse_weighted, w.u_free);
    s.yielded += tick.h * w.u_free.tail(s.yielded.size());
  }
  for (int i = 0; i < m.model.patch.num_vertices(); ++i) {
    if (const Vec3 moving = tick.h * node(w.impulse_weighted, i); !moving.isZero(0)) {
      s.q.noalias() += Y.middleCols<3>(3 * i) * moving;
      w.patch_motion.noalias() += C.middleCols<3>(3 * i) * moving;
    }
    if (!node(w.impulse, i).isZero(0)) s.q_rate.noalias() += Y_end.middleCols<3>(3 * i) * node(w.impulse, i);
  }
  w.motion_of = s.q;
}

/// The contacts that the next tick goes on from: those without an impulse are let go.
void keep_anchors(TickState& tick) noexcept {
  LocalState& s = tick.model->state;
  ContactSet& contacts = tick.contacts;
  ContactSolution& solution = tick.solution;
  s.anchors.count = 0;
  int kept = 0;
  for (int i = 0; i < contacts.count; ++i) {
    if (solution.mode[i] == ContactMode::free) continue;
    contacts.contacts[kept] = contacts.contacts[i];
    s.impulse[kept] = solution.impulse.segment<3>(3 * i);
    solution.mode[kept] = solution.mode[i];
    solution.grip[kept] = solution.grip[i];
    s.anchors.add(contacts.contacts[kept++]);
  }
  contacts.count = kept;
}

void report_coulomb_forces(TickState& tick, std::span<LocalFrame> frames) noexcept {
  for (int k = 0; k < tick.num_tools(); ++k) frames[k].force.setZero();
  for (int i = 0; i < tick.contacts.count; ++i)
    frames[tick.contacts.contacts[i].tool].force -= tick.model->state.impulse[i] / tick.h;
  for (int k = 0; k < tick.num_tools(); ++k) report_contacts(tick, k, frames[k]);
}

}  // namespace

void step_coulomb(TickState& tick, std::span<LocalFrame> frames) noexcept {
  find_held_tools(tick);
  if (std::ranges::any_of(tick.tools, [](const TouchingTool& tool) { return tool.start >= 0; })) {
    for (TouchingTool& tool : tick.tools) tool.rest.move(tool.whole.sweep());
  } else if (!fly_to_impact(tick, frames)) {
    return accept_free_motion(tick);
  }
  hold_contacts(tick, frames);
  advance_body(tick);
  keep_anchors(tick);
  settle_velocities(tick);
  report_coulomb_forces(tick, frames);
}

}  // namespace kt
