// The tick of the paper's laws: the surface is put under the tool, the forces there are computed, and the operators
// decide what the tool feels and how the surface moves on.                              Paper sections IV.A and V,
// figure 2. docs/method.md#6-the-papers-laws-528 names the function of each equation.
#include <algorithm>

#include "haptics/contact/projection.hpp"
#include "haptics/tick/local_simulation.hpp"

namespace kt {

/// The one contact of a tick, as its stages hand it on.
struct LocalSimulation::PaperContact {
  Contact contact;
  double toi = 0;               ///< time of collision, of the tick [-]
  double s = 0;                 ///< of J J^T = s I, see weight_square()
  Vec3 target = Vec3::Zero();   ///< where the contact point belongs: on the tool's surface [m]
  std::array<bool, 3> moves{};  ///< which vertices of the triangle can
  Triangle triangle{};          ///< their numbers in the patch
  double weight(int c) const { return contact.bary[c] / s; }  ///< of J^T / s
};

void LocalSimulation::step_geometric(const ToolSweep& sweep, LocalFrame& frame) noexcept {
  PaperContact c;
  if (!return_to_collision(c, frame)) return accept_free_motion();
  if (!push_triangle_onto_tool(sweep, c)) return accept_free_motion();
  find_constraint_force(c);
  solver_->solve(problem_, solution_);
  if (solution_.mode[0] == ContactMode::free) return let_surface_go(c, frame);
  advance_constrained(c);
  c.contact.core = sweep.x_t1;
  report_paper_force(c, frame);
  carry_contact_over(c);
}

/// The surface moves freely until it collides with the tool; contact of the last tick goes on from its start. False: no
/// collision in this tick.
bool LocalSimulation::return_to_collision(PaperContact& c, LocalFrame& frame) noexcept {
  LocalWorkspace& w = model_->work;
  LocalState& state = model_->state;
  std::ranges::fill(w.ignored[0], 0);
  w.x_event = w.x;
  if (state.anchors.count) {
    c.contact = state.anchors.contacts[0];
    return true;
  }
  w.x_end = w.x + h_ * w.u_free;
  if (!find_impact(c.contact)) return false;
  c.toi = c.contact.toi;
  state.q += c.toi * h_ * w.v_free;
  w.x += c.toi * (w.x_end - w.x);
  state.q_rate = w.v_free;
  frame.toi = c.toi;
  ++frame.events;
  return true;
}

/// dx = J^T d / s puts the contact point onto the tool: along the normal without friction, wholly with friction. False:
/// nothing there can move, the paper has no answer.
bool LocalSimulation::push_triangle_onto_tool(const ToolSweep& sweep, PaperContact& c) noexcept {
  PreparedLocalModel& m = *model_;
  LocalWorkspace& w = m.work;
  c.triangle = m.model.patch.triangles[c.contact.triangle];
  std::copy_n(m.moves[c.contact.triangle].begin(), 3, c.moves.begin());
  c.s = weight_square(c.contact.bary, c.moves);
  const Vec3 face = face_normal(m.model.patch, w.x, c.contact.triangle);
  if (c.s < 1e-12 || face.isZero(0)) {
    tools_[0].flags |= kRigidContact;
    return false;
  }
  c.target = sweep.x_t1 - tools_[0].moving.shape().radius * face;
  Vec3 d = c.target;
  for (int i = 0; i < 3; ++i) d -= c.contact.bary[i] * node(w.x, c.triangle[i]);
  if (solver_->deformation() == Deformation::normal) d = face.dot(d) * face;
  w.q_trial = m.state.q;
  for (int i = 0; i < 3; ++i) {
    const Vec3 push = c.weight(i) * d;
    if (c.moves[i]) m.state.q.noalias() += m.model.lift.middleCols(3 * c.triangle[i], 3) * push;
  }
  return true;
}

/// What the operators project: force J f / s and velocity of the contact point of the deformed body, for the rest of
/// the tick.
void LocalSimulation::find_constraint_force(PaperContact& c) noexcept {
  PreparedLocalModel& m = *model_;
  LocalWorkspace& w = m.work;
  const LocalState& state = m.state;
  m.dynamics->force(state.q, state.q_rate, w.force);
  m.dynamics->free_motion(state.q, state.q_rate, w.v_free, w.v_free_end);
  w.v_free = state.q_rate + (1 - c.toi) * (w.v_free - state.q_rate);
  m.recover_patch(state.q, w.x_end);
  w.x_end += m.model.x0.head(w.x.size());
  m.recover_patch(w.v_free, w.u_free);
  w.x_guess.noalias() = m.model.lift.leftCols(w.x.size()).transpose() * w.force;

  problem_.count = 1;
  problem_.h = (1 - c.toi) * h_;
  problem_.triangle[0] = m.model.patch.global_triangle[c.contact.triangle];
  c.contact.normal = problem_.normal[0] = face_normal(m.model.patch, w.x_end, c.contact.triangle);
  problem_.velocity.setZero(3);
  problem_.force.setZero();
  problem_.W.setZero(3, 3);
  problem_.inertia.setZero();
  for (int i = 0; i < 3; ++i) {
    problem_.velocity += c.contact.bary[i] * node(w.u_free, c.triangle[i]);
    problem_.force += c.weight(i) * node(w.x_guess, c.triangle[i]);
    for (int k = 0; k < 3; ++k) {
      const double both = c.contact.bary[i] * c.contact.bary[k];
      problem_.W += both * m.dynamics->metric().C.block<3, 3>(3 * c.triangle[i], 3 * c.triangle[k]);
      problem_.inertia += both * m.dynamics->inertia().C.block<3, 3>(3 * c.triangle[i], 3 * c.triangle[k]);
    }
  }
}

/// The surface would pull: no push, no force. Where it then comes to lie over the tool (it springs back, or an explicit
/// step chatters) contact goes on from there in the next tick; else it has ended.
void LocalSimulation::let_surface_go(const PaperContact& c, LocalFrame& frame) noexcept {
  PreparedLocalModel& m = *model_;
  LocalWorkspace& w = m.work;
  LocalState& state = m.state;
  state.q = w.q_trial;
  find_free_motion();
  w.v_free = state.q_rate + (1 - c.toi) * (w.v_free - state.q_rate);
  state.q += problem_.h * w.v_free;
  state.q_rate = w.v_free;
  m.recover_patch(state.q, w.x_end);
  w.x_end += m.model.x0.head(w.x.size());
  const Contact next = nearest_point_contact(m.model.patch, w.x_end, c.target);
  state.anchors.count = 0;
  if (next.gap > 0) return;
  state.anchors.add(next);
  contacts_.count = 0;
  contacts_.add(next);
  state.impulse[0].setZero();
  report_contacts(0, frame);
  frame.mode = solver_->deformation() == Deformation::full ? ContactMode::stick : ContactMode::slide;
  frame.triangle = frame.facet = m.model.patch.global_triangle[next.triangle];
}

/// v+ = P v* (or Q v*, with the clipped force taken off);  x+ = x + v+ h.              Paper eqs. (12), (20), (26).
void LocalSimulation::advance_constrained(const PaperContact& c) noexcept {
  const LocalDynamics& dynamics = *model_->dynamics;
  LocalState& state = model_->state;
  state.q_rate = model_->work.v_free;
  for (int i = 0; i < 3; ++i) {
    const int column = 3 * c.triangle[i];
    state.q_rate.noalias() += dynamics.metric().Y.middleCols<3>(column) * (c.contact.bary[i] * solution_.impulse);
    state.q_rate.noalias() +=
        dynamics.inertia().Y.middleCols<3>(column) * (c.contact.bary[i] * solution_.inertial_impulse);
  }
  state.q.noalias() += problem_.h * state.q_rate;
}

void LocalSimulation::report_paper_force(const PaperContact& c, LocalFrame& frame) noexcept {
  frame.force = solution_.force_on_tool;
  model_->state.impulse[0] = -h_ * solution_.force_on_tool;
  contacts_.count = 0;
  contacts_.add(c.contact);
  report_contacts(0, frame);
}

/// Sticking keeps the material point; sliding takes the one that is under the tool now, perhaps on a neighbour.
void LocalSimulation::carry_contact_over(const PaperContact& c) noexcept {
  LocalWorkspace& w = model_->work;
  LocalState& state = model_->state;
  Contact next = c.contact;
  if (solution_.mode[0] != ContactMode::stick) {
    model_->recover_patch(state.q, w.x_end);
    w.x_end += model_->model.x0.head(w.x.size());
    next = track_point_contact(model_->model.patch, w.x_end, c.target, next.triangle);
  }
  state.anchors.count = 0;
  state.anchors.add(next);
}

}  // namespace kt
