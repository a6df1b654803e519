// The tick of the paper's laws: the surface is put under the tool, the forces there are computed, and the operators
// decide what the tool feels and how the surface moves on.                              Paper sections IV.A and V.
#include <algorithm>

#include "haptics/contact/projection.hpp"
#include "haptics/local_simulation.hpp"

namespace kt {

void LocalSimulation::step_geometric(const ToolSweep& sweep, LocalFrame& frame) noexcept {
  PreparedLocalModel& m = *model_;
  LocalWorkspace& w = m.work;
  LocalState& s = m.state;
  const SurfacePatch& patch = m.model.patch;
  std::ranges::fill(w.ignored[0], 0);
  w.x_event = w.x;
  Contact contact;
  double toi = 0;

  // Collision between the instrument and a triangle during the step? Then back to the time of collision.
  if (s.anchors.count) {
    contact = s.anchors.contacts[0];
  } else {
    w.x_end = w.x + h_ * w.u_free;
    if (!find_impact(contact)) return accept_free_motion();
    toi = contact.toi;
    s.q += toi * h_ * w.v_free;
    w.x += toi * (w.x_end - w.x);
    s.q_rate = w.v_free;
    frame.toi = toi;
    ++frame.events;
  }
  const double h_left = (1 - toi) * h_;
  const Triangle& t = patch.triangles[contact.triangle];
  const auto& moves = m.moves[contact.triangle];
  const double weight = weight_square(contact.bary, moves);
  const Vec3 face = face_normal(patch, w.x, contact.triangle);
  if (weight < 1e-12 || face.isZero(0)) {  // nothing there can move: the geometric laws have no answer
    tools_[0].flags |= kRigidContact;
    return accept_free_motion();
  }

  // Push the contact point onto the tool: dx = J^T d / s.
  const Vec3 target = sweep.x_t1 - tools_[0].moving.shape().radius * face;
  Vec3 d = target;
  for (int c = 0; c < 3; ++c) d -= contact.bary[c] * node(w.x, t[c]);
  if (solver_->deformation() == Deformation::normal) d = face.dot(d) * face;
  w.q_trial = s.q;
  for (int c = 0; c < 3; ++c) {
    const Vec3 push = contact.bary[c] / weight * d;
    if (moves[c]) s.q.noalias() += m.model.lift.middleCols(3 * t[c], 3) * push;
  }

  // Force of the deformed body at the contact point, and its motion without the constraint.
  m.dynamics->force(s.q, s.q_rate, w.force);
  m.dynamics->free_motion(s.q, s.q_rate, w.v_free, w.v_free_end);
  w.v_free = s.q_rate + (1 - toi) * (w.v_free - s.q_rate);
  m.recover_patch(s.q, w.x_end);
  w.x_end += m.model.x0.head(w.x.size());
  m.recover_patch(w.v_free, w.u_free);
  w.x_guess.noalias() = m.model.lift.leftCols(w.x.size()).transpose() * w.force;

  problem_.count = 1;
  problem_.h = h_left;
  problem_.triangle[0] = patch.global_triangle[contact.triangle];
  contact.normal = problem_.normal[0] = face_normal(patch, w.x_end, contact.triangle);
  problem_.velocity.setZero(3);
  problem_.force.setZero();
  problem_.W.setZero(3, 3);
  problem_.inertia.setZero();
  for (int c = 0; c < 3; ++c) {
    problem_.velocity += contact.bary[c] * node(w.u_free, t[c]);
    problem_.force += contact.bary[c] / weight * node(w.x_guess, t[c]);
    for (int k = 0; k < 3; ++k) {
      const double both = contact.bary[c] * contact.bary[k];
      problem_.W += both * m.dynamics->metric().C.block<3, 3>(3 * t[c], 3 * t[k]);
      problem_.inertia += both * m.dynamics->inertia().C.block<3, 3>(3 * t[c], 3 * t[k]);
    }
  }
  solver_->solve(problem_, solution_);
  // The surface would pull: no push, no force. Where it then comes to lie over the tool (it springs back, or an
  // explicit step chatters) contact goes on from there in the next tick; else it has ended.
  if (solution_.mode[0] == ContactMode::free) {
    s.q = w.q_trial;
    find_free_motion();
    w.v_free = s.q_rate + (1 - toi) * (w.v_free - s.q_rate);
    s.q += h_left * w.v_free;
    s.q_rate = w.v_free;
    m.recover_patch(s.q, w.x_end);
    w.x_end += m.model.x0.head(w.x.size());
    const Contact next = nearest_point_contact(patch, w.x_end, target);
    s.anchors.count = 0;
    if (next.gap > 0) return;
    s.anchors.add(next);
    contacts_.count = 0;
    contacts_.add(next);
    s.impulse[0].setZero();
    report_contacts(0, frame);
    frame.mode = solver_->deformation() == Deformation::full ? ContactMode::stick : ContactMode::slide;
    frame.triangle = frame.facet = patch.global_triangle[next.triangle];
    return;
  }

  // v+ = P v* (or Q v*, with the clipped force taken off);  x+ = x + v+ h.            Paper eqs. (12), (20), (26).
  s.q_rate = w.v_free;
  for (int c = 0; c < 3; ++c) {
    s.q_rate.noalias() += m.dynamics->metric().Y.middleCols<3>(3 * t[c]) * (contact.bary[c] * solution_.impulse);
    s.q_rate.noalias() +=
        m.dynamics->inertia().Y.middleCols<3>(3 * t[c]) * (contact.bary[c] * solution_.inertial_impulse);
  }
  s.q.noalias() += h_left * s.q_rate;
  frame.force = solution_.force_on_tool;
  s.impulse[0] = -h_ * solution_.force_on_tool;
  contact.core = sweep.x_t1;
  contacts_.count = 0;
  contacts_.add(contact);
  report_contacts(0, frame);

  // Sticking keeps the material point; sliding takes the one that is under the tool now, perhaps on a neighbour.
  if (solution_.mode[0] != ContactMode::stick) {
    m.recover_patch(s.q, w.x_end);
    w.x_end += m.model.x0.head(w.x.size());
    contact = track_point_contact(patch, w.x_end, target, contact.triangle);
  }
  s.anchors.count = 0;
  s.anchors.add(contact);
}

}  // namespace kt
