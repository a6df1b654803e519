#include "haptics/local_simulation.hpp"

#include <cmath>

#include "collision/first_contact.hpp"

namespace kt {

LocalSimulation::LocalSimulation(const ToolShape& tool, double h, std::unique_ptr<ContactSolver> solver)
    : tool_(tool), h_(h), solver_(std::move(solver)) {
  problem_.velocity.setZero(3 * kMaxContacts);
  problem_.W.setZero(3 * kMaxContacts, 3 * kMaxContacts);
  solution_.impulse.setZero(0);
}

std::unique_ptr<PreparedLocalModel> LocalSimulation::adopt(std::unique_ptr<PreparedLocalModel> next) noexcept {
  std::swap(model_, next);
  if (!next) return next;
  PreparedLocalModel& now = *model_;
  PreparedLocalModel& old = *next;

  // Where the old model's nodes are, in the new model's coordinates.
  old.work.x_recovered = old.model.x0;
  old.work.x_recovered.noalias() += old.model.basis * old.state.q;
  old.work.v_recovered.noalias() = old.model.basis * old.state.q_rate;
  LocalWorkspace& w = now.work;
  for (int i = 0; i < static_cast<int>(now.model.recovered_node.size()); ++i) {
    const int row = old.recovered_row[now.model.recovered_node[i]];
    node(w.x_recovered, i) =
        row < 0 ? Vec3(Vec3::Zero()) : Vec3(node(old.work.x_recovered, row) - node(now.model.x0, i));
    node(w.v_recovered, i) =
        row < 0 ? Vec3(Vec3::Zero()) : Vec3(node(old.work.v_recovered, row) - node(now.model.v0, i));
  }
  now.state.q.noalias() = now.model.lift * w.x_recovered;
  now.state.q_rate = now.model.q_rate0;
  now.state.q_rate.noalias() += now.model.lift_rate * w.v_recovered;

  now.state.anchors.count = 0;
  for (Contact anchor : old.state.anchors) {
    anchor.triangle = now.local_triangle[old.model.patch.global_triangle[anchor.triangle]];
    if (anchor.triangle < 0)
      flags_ |= kLostAnchor;
    else
      now.state.anchors.add(anchor);
  }
  // The motion that contact causes goes on: the first guess of the next tick.
  for (int i = 0; i < now.model.patch.num_vertices(); ++i) {
    const int row = old.recovered_row[now.model.patch.global_node[i]];
    node(w.du, i) =
        row >= 0 && row < old.model.patch.num_vertices() ? Vec3(node(old.work.du, row)) : Vec3(Vec3::Zero());
  }
  return next;
}

void LocalSimulation::set_force(const VectorX& force) noexcept {
  LocalModel& m = model_->model;
  const LocalState& s = model_->state;
  m.f0 = force;
  m.f0.noalias() += m.stiffness * s.q;
  m.f0.noalias() += m.damping * s.q_rate;
}

void LocalSimulation::find_free_motion() noexcept {
  PreparedLocalModel& m = *model_;
  LocalWorkspace& w = m.work;
  w.x = m.model.x0.head(w.x.size());
  w.x.noalias() += m.patch_basis * m.state.q;
  m.dynamics->free_velocity(m.state.q, m.state.q_rate, w.v_free);
  w.u_free.noalias() = m.patch_basis * w.v_free;
}

bool LocalSimulation::find_impact(const ToolSweep& sweep, Contact& impact) noexcept {
  PreparedLocalModel& m = *model_;
  m.index->refit(m.work.x_event, m.work.x_end);
  const MovingTriangles surface{m.model.patch.triangles, m.work.x_event, m.work.x_end};
  const auto found = find_first_contact(*m.index, surface, tool_, sweep, m.work.ignored, m.work.candidates);
  if (found) impact = *found;
  return found.has_value();
}

void LocalSimulation::accept_free_motion() noexcept {
  LocalState& s = model_->state;
  s.q.noalias() += h_ * model_->work.v_free;
  s.q_rate = model_->work.v_free;
  s.anchors.count = 0;
  model_->work.du.setZero();
}

LocalFrame LocalSimulation::step(const ToolSweep& sweep) noexcept {
  LocalFrame frame;
  num_samples_ = 0;
  t_ += h_;
  frame.t = t_;
  frame.tool = sweep.x_t1;
  frame.model_frame = model_->model.frame;

  find_free_motion();
  if (solver_->deformation() == Deformation::none)
    step_constrained(sweep, frame);
  else
    step_geometric(sweep, frame);

  LocalState& s = model_->state;
  if (!s.q.allFinite() || !s.q_rate.allFinite() || !frame.force.allFinite()) {
    s.q.setZero();  // back to the linearization pose: the last state known to be good
    s.q_rate.setZero();
    s.anchors.count = 0;
    num_samples_ = 0;
    frame.force.setZero();
    frame.mode = ContactMode::free;
    flags_ |= kNotFinite;
  }
  sliding_ = frame.mode == ContactMode::frictional_slide;
  frame.flags = flags_;
  flags_ = 0;
  return frame;
}

/// Splits the tick's impulses into what is reported and what goes to the global side.
void LocalSimulation::report_contacts(LocalFrame& frame) noexcept {
  const SurfacePatch& patch = model_->model.patch;
  Vec3 normal_sum = Vec3::Zero(), tangential_sum = Vec3::Zero();
  double largest = 0;
  frame.contacts = contacts_.count;
  frame.gap = contacts_.count ? contacts_.contacts[0].gap : 0;
  for (int i = 0; i < contacts_.count; ++i) {
    const Contact& contact = contacts_.contacts[i];
    const Vec3 force = -body_impulse_[i] / h_;
    const double f_n = force.dot(contact.normal);
    const Vec3 f_t = force - f_n * contact.normal;
    normal_sum += f_n * contact.normal;
    tangential_sum += f_t;
    frame.gap = std::min(frame.gap, contact.gap);
    if (f_n > 0) frame.cone_ratio = std::max(frame.cone_ratio, f_t.norm() / f_n);
    if (f_n > largest) {
      largest = f_n;
      frame.triangle = patch.global_triangle[contact.triangle];
      frame.mode = solution_.mode[i];
      frame.normal = contact.normal;
      if (patch.on_rim[contact.triangle]) flags_ |= kLeftPatch;
    }
    const Triangle& t = patch.triangles[contact.triangle];
    ContactSample& sample = samples_[num_samples_++];
    sample.t = t_ - h_;
    sample.bary = contact.bary;
    sample.impulse = body_impulse_[i];
    sample.normal = contact.normal;
    sample.sticks = solution_.mode[i] == ContactMode::stick;
    sample.point = frame.tool - (tool_.radius + contact.gap) * contact.normal;
    for (int c = 0; c < 3; ++c) sample.nodes[c] = patch.global_node[t[c]];
  }
  frame.f_n = normal_sum.norm();
  frame.f_t = tangential_sum.norm();
}

}  // namespace kt
