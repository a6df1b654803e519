// The motion of the local body that nothing touches, and the part of the surface that tools may meet on it.
#include "haptics/tick/tick_stages.hpp"

namespace kt {
namespace {

constexpr double kMargin = 0.1;  // of the tool's reach: more than contacts are looked for within

/// The basis is the largest thing that a tick reads, so it is read once, for the velocities: where the last tick ended
/// the motion is known from them, to rounding.
void recover_patch_motion(PreparedLocalModel& m) noexcept {
  LocalWorkspace& w = m.work;
  if (w.motion_of == m.state.q) return;
  m.recover_patch(m.state.q, w.patch_motion);
  w.motion_of = m.state.q;
}

/// Whether a tool may meet the patch's rim or what is beyond in this tick; the rest of the surface costs its time only
/// then.
/// @param moved  most that a coordinate of the patch has moved since the linearization [m]
bool comes_near_apron(const TickState& tick, double moved) noexcept {
  const PreparedLocalModel& m = *tick.model;
  if (!m.wide_index) return false;
  for (int k = 0; k < tick.num_tools(); ++k) {
    const ToolSweep& sweep = tick.tools[k].whole.sweep();
    const double way = (sweep.x_t1 - sweep.x_t0).norm();
    const double away = (sweep.x_t0 - m.clear_from[k]).norm() + 2 * way + 2 * moved;  // a diagonal is 1.8 coordinates
    if (away + (1 + kMargin) * tick.tools[k].reach >= m.clear[k]) return true;
  }
  return false;
}

}  // namespace

void find_free_motion(TickState& tick) noexcept {
  PreparedLocalModel& m = *tick.model;
  LocalWorkspace& w = m.work;
  recover_patch_motion(m);
  const Eigen::Index patch = w.patch_motion.size();
  w.motion.head(patch) = w.patch_motion;
  w.motion.tail(m.state.yielded.size()) = m.state.yielded;
  const double moved = w.motion.lpNorm<Eigen::Infinity>();
  tick.near_apron = comes_near_apron(tick, moved);
  if (tick.near_apron) cover_tools(tick, false, moved);
  w.motion.head(patch) += m.model.x0.head(patch);
  m.surface.place(w.motion, w.x);
  if (tick.near_apron) m.surface.place_apron(w.motion, w.x);
  m.dynamics->free_motion(m.state.q, m.state.q_rate, w.v_free, w.v_free_end);
  m.recover_patch(w.v_free, w.u_free);
  m.yield_freely(w.u_free);
}

void cover_tools(TickState& tick, bool at_end, double moved) noexcept {
  PreparedLocalModel& m = *tick.model;
  if (!m.apron || m.apron->has_all()) return;
  std::array<Vec3, kMaxTools> places;
  bool is_covered = true;
  for (int k = 0; k < tick.num_tools(); ++k) {
    const ToolSweep& sweep = tick.tools[k].whole.sweep();
    places[k] = at_end ? sweep.x_t1 : sweep.x_t0;
    const double way = at_end ? 0 : (sweep.x_t1 - sweep.x_t0).norm();
    const double need = (1 + kMargin) * tick.tools[k].reach + 2 * way + 2 * moved + m.apron->motion().lowered;
    is_covered = is_covered && m.apron->covers(k, places[k], need);
  }
  if (!is_covered) move_apron(m, {places.data(), tick.tools.size()});
}

void follow(const TickState& tick, const VectorX& patch, VectorX& out) noexcept {
  tick.model->surface.follow(patch, out);
  if (tick.near_apron) tick.model->surface.follow_apron(patch, out);
}

void accept_free_motion(TickState& tick) noexcept {
  LocalState& s = tick.model->state;
  LocalWorkspace& w = tick.model->work;
  const bool is_known = w.motion_of == s.q;
  s.q.noalias() += tick.h * w.v_free;
  s.q_rate = w.v_free_end;
  s.yielded += tick.h * w.u_free.tail(s.yielded.size());
  if (is_known) {
    w.patch_motion += tick.h * w.u_free.head(w.patch_motion.size());
    w.motion_of = s.q;
  }
  s.anchors.count = 0;
  w.du.setZero();
}

}  // namespace kt
