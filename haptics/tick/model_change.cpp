#include "haptics/tick/model_change.hpp"

#include <algorithm>
#include <tuple>

#include "haptics/tick/tick_stages.hpp"

namespace kt {
namespace {

/// How much longer than usual the force fades over from a model that was in use for that time [s]: the body is far from
/// where it was linearized.
double fade_after(double in_use) noexcept {
  constexpr double kUsual = 0.05, kFaded = 0.03, kMost = 8;
  return in_use <= kUsual ? 1 : std::min(kMost, in_use / kFaded);
}

bool touches(const ContactSet& contacts, int tool) noexcept {
  return std::ranges::find(contacts, tool, &Contact::tool) != contacts.end();
}

void begin_blends(TickState& tick, const PreparedLocalModel& now, const PreparedLocalModel& old) noexcept {
  const double in_use = tick.h * (now.linearized_tick - old.linearized_tick);  // [s]
  for (int k = 0; k < tick.num_tools(); ++k)
    tick.tools[k].blend.begin(now.caught_up ? now.replayed_force[k] : std::nullopt, fade_after(in_use));
}

/// Contacts of the old model that the new one's patch or apron has too.
void carry_contacts(TickState& tick, PreparedLocalModel& now, const PreparedLocalModel& old) noexcept {
  now.state.anchors.count = 0;
  for (int i = 0; i < old.state.anchors.count; ++i) {
    Contact anchor = old.state.anchors.contacts[i];
    if (old.surface.fine || now.surface.fine || old.surface.levels != now.surface.levels)
      std::tie(anchor.triangle, anchor.bary) = now.facet_at(old.surface.place_of(anchor.triangle, anchor.bary));
    else
      anchor.triangle = now.local_facet(old.surface.global_facet(anchor.triangle));
    if (anchor.triangle < 0) {
      tick.tools[anchor.tool].flags |= kLostAnchor;
      continue;
    }
    now.state.impulse[now.state.anchors.count] = old.state.impulse[i];
    now.state.anchors.add(anchor);
  }
  now.state.sliding = old.state.sliding;
}

/// Where the apron of a new model was in the old one: as its patch moved, or where the body was linearized.
void place_apron_before(const PreparedLocalModel& old, const LocalMotion& motion, PreparedLocalModel& now) noexcept {
  const ContactSurface& surface = now.surface;
  for (int v = surface.apron_vertices; v >= 0 && v < surface.facets.num_vertices(); ++v) {
    const int global = surface.facets.global_node[v], row = motion.row[global];
    if (row >= 0)
      node(now.work.x_event, v) = node(motion.x, row);
    else if (old.body_x.size() > 0)
      node(now.work.x_event, v) = node(old.body_x, global);
  }
}

/// The surface where the old model had it, x_event, and where the new one has it, x and x_end.
void place_both(TickState& tick, const PreparedLocalModel& old) noexcept {
  PreparedLocalModel& m = *tick.model;
  LocalWorkspace& w = m.work;
  record_motion(old, 0, tick.motion);
  tick.near_apron = m.wide_index != nullptr;
  cover_tools(tick, true, 0);
  m.recover_patch(m.state.q, w.motion);
  const Eigen::Index patch = 3 * static_cast<Eigen::Index>(m.model.patch.num_vertices());
  w.motion.head(patch) += m.model.x0.head(patch);
  w.motion.tail(m.state.yielded.size()) = m.state.yielded;
  m.surface.place(w.motion, w.x);
  m.surface.place_apron(w.motion, w.x);
  w.x_end = w.x;
  for (int i = 0; i < m.model.patch.num_vertices(); ++i)
    if (const int row = tick.motion.row[m.model.patch.global_node[i]]; row >= 0)
      node(w.motion, i) = node(tick.motion.x, row);
  m.surface.place(w.motion, w.x_event);
  place_apron_before(old, tick.motion, m);
}

/// A refresh moves the surface, from where the old model had it to where the new one does, in no time. A tool that it
/// goes through is touched from then on, and pushed out over some ticks.
void sweep_surface(TickState& tick, const PreparedLocalModel& old) noexcept {
  PreparedLocalModel& m = *tick.model;
  LocalWorkspace& w = m.work;
  std::array<bool, kMaxTools> is_free{};
  for (int k = 0; k < tick.num_tools(); ++k) is_free[k] = !touches(m.state.anchors, k);
  if (tick.t == 0 || std::ranges::count(is_free, true) == 0 || tick.solver->deformation() != Deformation::none) return;
  place_both(tick, old);
  tick.index().refit(w.x_event, w.x_end);
  for (int k = 0; k < tick.num_tools(); ++k) {
    if (!is_free[k]) continue;
    MovingTool& still = tick.tools[k].rest;
    const ToolSweep last = tick.tools[k].whole.sweep();
    still.move({last.x_t1, last.x_t1, last.r_t1, last.r_t1});
    std::ranges::fill(w.ignored[k], 0);
    auto touched = find_impact_of(tick, k, still);
    if (!touched || find_overlap(tick, k, still) < 0) continue;
    m.state.impulse[m.state.anchors.count].setZero();
    touched->core = last.x_t1;
    m.state.anchors.add(*touched);
  }
}

}  // namespace

void change_model(TickState& tick, PreparedLocalModel& now, const PreparedLocalModel* old) noexcept {
  use_model(tick, now);
  tick.has_new_patch = true;
  if (!old) {
    tick.motion = make_local_motion(static_cast<int>(now.recovered_row.size()));
    return;
  }
  begin_blends(tick, now, *old);
  if (now.caught_up) {
    for (int k = 0; k < tick.num_tools(); ++k)
      if (!touches(now.state.anchors, k) && touches(old->state.anchors, k)) tick.tools[k].flags |= kLostAnchor;
  } else {
    record_motion(*old, 0, tick.motion);
    carry_motion(tick.motion, now, old->surface.fine.get());
    now.state.anchors.count = 0;  // the apron may move: nothing of it is held
    if (tick.t > 0) cover_tools(tick, true, 0);
    carry_contacts(tick, now, *old);
  }
  sweep_surface(tick, *old);
}

}  // namespace kt
