#include "haptics/tick/paper_tick.hpp"

#include <algorithm>

#include "haptics/contact/projection.hpp"
#include "haptics/tick/tick_stages.hpp"

namespace kt {
namespace {

/// The one contact of a tick, as its stages hand it on.
struct PaperContact {
  Contact contact;
  double toi = 0;               ///< time of collision, of the tick [-]
  double s = 0;                 ///< of J J^T = s I, see weight_square()
  Vec3 target = Vec3::Zero();   ///< where the contact point belongs: on the tool's surface [m]
  std::array<bool, 3> moves{};  ///< which vertices of the triangle can
  Triangle triangle{};          ///< their numbers in the patch
  double weight(int c) const { return contact.bary[c] / s; }  ///< of J^T / s
};

/// The surface moves freely until it collides with the tool; contact of the last tick goes on from its start. False: no
/// collision in this tick.
bool return_to_collision(TickState& tick, PaperContact& c, LocalFrame& frame) noexcept {
  LocalWorkspace& w = tick.model->work;
  LocalState& state = tick.model->state;
  std::ranges::fill(w.ignored[0], 0);
  w.x_event = w.x;
  if (state.anchors.count) {
    c.contact = state.anchors.contacts[0];
    return true;
  }
  w.x_end = w.x + tick.h * w.u_free;
  const std::optional<Contact> impact = find_impact(tick, &TouchingTool::whole);
  if (!impact) return false;
  c.contact = *impact;
  c.toi = impact->toi;
  state.q += c.toi * tick.h * w.v_free;
  w.x += c.toi * (w.x_end - w.x);
  state.q_rate = w.v_free;
  frame.toi = c.toi;
  ++frame.events;
  return true;
}

/// dx = J^T d / s puts the contact point onto the tool: along the normal without friction, wholly with friction. False:
/// nothing there can move, the paper has no answer.
/// @param pushed  coordinates of the body with the triangle there [m], (r)
bool push_triangle_onto_tool(TickState& tick, PaperContact& c, VectorX& pushed) noexcept {
  const PreparedLocalModel& m = *tick.model;
  TouchingTool& tool = tick.tools[0];
  c.triangle = m.model.patch.triangles[c.contact.triangle];
  std::copy_n(m.moves[c.contact.triangle].begin(), 3, c.moves.begin());
  c.s = weight_square(c.contact.bary, c.moves);
  const Vec3 face = face_normal(m.model.patch, m.work.x, c.contact.triangle);
  if (c.s < 1e-12 || face.isZero(0)) {
    tool.flags |= kRigidContact;
    return false;
  }
  c.target = tool.whole.sweep().x_t1 - tool.shape().radius * face;
  Vec3 d = c.target;
  for (int i = 0; i < 3; ++i) d -= c.contact.bary[i] * node(m.work.x, c.triangle[i]);
  if (tick.solver->deformation() == Deformation::normal) d = face.dot(d) * face;
  pushed = m.state.q;
  for (int i = 0; i < 3; ++i) {
    const Vec3 push = c.weight(i) * d;
    if (c.moves[i]) pushed.noalias() += m.model.lift.middleCols(3 * c.triangle[i], 3) * push;
  }
  return true;
}

/// Where the patch's vertices are at these coordinates [m], (3p).
void place_patch(const PreparedLocalModel& m, const VectorX& q, VectorX& out) noexcept {
  m.recover_patch(q, out);
  out += m.model.x0.head(out.size());
}

/// What the operators project: force J f / s and velocity of the contact point of the deformed body, for the rest of
/// the tick.
/// @param pushed  coordinates of that body [m], (r)
void find_constraint_force(TickState& tick, PaperContact& c, const VectorX& pushed) noexcept {
  PreparedLocalModel& m = *tick.model;
  LocalWorkspace& w = m.work;
  const VectorX& rate = m.state.q_rate;
  m.dynamics->force(pushed, rate, w.force);
  m.dynamics->free_motion(pushed, rate, w.v_free, w.v_free_end);
  w.v_free = rate + (1 - c.toi) * (w.v_free - rate);
  place_patch(m, pushed, w.x_end);
  m.recover_patch(w.v_free, w.u_free);
  w.x_guess.noalias() = m.model.lift.leftCols(w.x.size()).transpose() * w.force;

  ContactProblem& problem = tick.problem;
  problem.count = 1;
  problem.h = (1 - c.toi) * tick.h;
  problem.triangle[0] = m.model.patch.global_triangle[c.contact.triangle];
  c.contact.normal = problem.normal[0] = face_normal(m.model.patch, w.x_end, c.contact.triangle);
  problem.velocity.setZero(3);
  problem.force.setZero();
  problem.W.setZero(3, 3);
  problem.inertia.setZero();
  for (int i = 0; i < 3; ++i) {
    problem.velocity += c.contact.bary[i] * node(w.u_free, c.triangle[i]);
    problem.force += c.weight(i) * node(w.x_guess, c.triangle[i]);
    for (int k = 0; k < 3; ++k) {
      const double both = c.contact.bary[i] * c.contact.bary[k];
      problem.W += both * m.dynamics->metric().C.block<3, 3>(3 * c.triangle[i], 3 * c.triangle[k]);
      problem.inertia += both * m.dynamics->inertia().C.block<3, 3>(3 * c.triangle[i], 3 * c.triangle[k]);
    }
  }
}

/// The surface would pull: no push, no force. Where it then comes to lie over the tool (it springs back, or an explicit
/// step chatters) contact goes on from there in the next tick; else it has ended.
void let_surface_go(TickState& tick, const PaperContact& c, LocalFrame& frame) noexcept {
  PreparedLocalModel& m = *tick.model;
  LocalWorkspace& w = m.work;
  LocalState& state = m.state;
  find_free_motion(tick);
  w.v_free = state.q_rate + (1 - c.toi) * (w.v_free - state.q_rate);
  state.q += tick.problem.h * w.v_free;
  state.q_rate = w.v_free;
  place_patch(m, state.q, w.x_end);
  const Contact next = nearest_point_contact(m.model.patch, w.x_end, c.target);
  state.anchors.count = 0;
  if (next.gap > 0) return;
  state.anchors.add(next);
  tick.contacts.count = 0;
  tick.contacts.add(next);
  state.impulse[0].setZero();
  report_contacts(tick, 0, frame);
  frame.mode = tick.solver->deformation() == Deformation::full ? ContactMode::stick : ContactMode::slide;
  frame.triangle = frame.facet = m.model.patch.global_triangle[next.triangle];
}

/// v+ = P v* (or Q v*, with the clipped force taken off);  x+ = x + v+ h.              Paper eqs. (12), (20), (26).
/// @param pushed  x [m], (r)
void advance_constrained(TickState& tick, const PaperContact& c, const VectorX& pushed) noexcept {
  const LocalDynamics& dynamics = *tick.model->dynamics;
  const ContactSolution& solution = tick.solution;
  LocalState& state = tick.model->state;
  state.q_rate = tick.model->work.v_free;
  for (int i = 0; i < 3; ++i) {
    const int column = 3 * c.triangle[i];
    state.q_rate.noalias() += dynamics.metric().Y.middleCols<3>(column) * (c.contact.bary[i] * solution.impulse);
    state.q_rate.noalias() +=
        dynamics.inertia().Y.middleCols<3>(column) * (c.contact.bary[i] * solution.inertial_impulse);
  }
  state.q = pushed;
  state.q.noalias() += tick.problem.h * state.q_rate;
}

void report_paper_force(TickState& tick, const PaperContact& c, LocalFrame& frame) noexcept {
  frame.force = tick.solution.force_on_tool;
  tick.model->state.impulse[0] = -tick.h * tick.solution.force_on_tool;
  tick.contacts.count = 0;
  tick.contacts.add(c.contact);
  report_contacts(tick, 0, frame);
}

/// Sticking keeps the material point; sliding takes the one that is under the tool now, perhaps on a neighbour.
void carry_contact_over(const TickState& tick, const PaperContact& c) noexcept {
  PreparedLocalModel& m = *tick.model;
  Contact next = c.contact;
  if (tick.solution.mode[0] != ContactMode::stick) {
    place_patch(m, m.state.q, m.work.x_end);
    next = track_point_contact(m.model.patch, m.work.x_end, c.target, next.triangle);
  }
  m.state.anchors.count = 0;
  m.state.anchors.add(next);
}

}  // namespace

void step_paper(TickState& tick, LocalFrame& frame) noexcept {
  PaperContact c;
  VectorX& pushed = tick.model->work.q_pushed;
  if (!return_to_collision(tick, c, frame)) return accept_free_motion(tick);
  if (!push_triangle_onto_tool(tick, c, pushed)) return accept_free_motion(tick);
  find_constraint_force(tick, c, pushed);
  tick.solver->solve(tick.problem, tick.solution);
  if (tick.solution.mode[0] == ContactMode::free) return let_surface_go(tick, c, frame);
  advance_constrained(tick, c, pushed);
  c.contact.core = tick.tools[0].whole.sweep().x_t1;
  report_paper_force(tick, c, frame);
  carry_contact_over(tick, c);
}

}  // namespace kt
