#include "lab/methods/tick_parts.hpp"

namespace kt {

Baseline::Baseline(const std::string& method, const HapticMethodOptions& options)
    : tool_(options.tools[0]),
      h_(options.h),
      solver_(make_contact_solver(options.law, options.friction, options.friction_of_triangle)) {
  if (solver_->deformation() != Deformation::none)
    throw InputError(text("local.method \"", method, "\" needs contact.law \"coulomb\", not \"", options.law,
                          "\": it has no place for the paper's operators"));
  solution_.impulse.setZero(0);
}

LocalFrame Baseline::next_frame(const ToolSweep& sweep) noexcept {
  LocalFrame frame;
  t_ += h_;
  frame.t = t_;
  frame.pose = {sweep.x_t1, sweep.r_t1};
  frame.model_frame = model_->model.frame;
  samples_.count = 0;
  return frame;
}

void find_free_motion(PreparedLocalModel& m) noexcept {
  LocalWorkspace& w = m.work;
  m.recover_patch(m.state.q, w.x);
  w.x += m.model.x0.head(w.x.size());
  m.dynamics->free_motion(m.state.q, m.state.q_rate, w.v_free, w.v_free_end);
  m.recover_patch(w.v_free, w.u_free);
}

void step_body(PreparedLocalModel& m) noexcept {
  LocalWorkspace& w = m.work;
  LocalState& s = m.state;
  s.q_rate = w.v_free_end;
  const MatrixX &Y = m.dynamics->metric().Y, &Y_end = m.dynamics->end_response();
  for (int i = 0; i < m.model.patch.num_vertices(); ++i) {
    if (node(w.impulse, i).isZero(0)) continue;
    w.v_free.noalias() += Y.middleCols<3>(3 * i) * node(w.impulse, i);
    s.q_rate.noalias() += Y_end.middleCols<3>(3 * i) * node(w.impulse, i);
  }
  s.q.noalias() += m.dynamics->h() * w.v_free;
  m.recover_patch(s.q, w.x_end);
  w.x_end += m.model.x0.head(w.x_end.size());
}

void add_impulse(PreparedLocalModel& m, int triangle, const Vec3& bary, const Vec3& impulse) noexcept {
  const Triangle& t = m.model.patch.triangles[triangle];
  for (int c = 0; c < 3; ++c) node(m.work.impulse, t[c]) += bary[c] * impulse;
}

bool soften(const PreparedLocalModel& m, ContactProblem& problem) noexcept {
  const double softest = softest_contact(m);
  bool softened = false;
  for (int i = 0; i < problem.count; ++i) {
    auto own = problem.W.block<3, 3>(3 * i, 3 * i);
    if (own.trace() >= 3 * softest) continue;
    own += softest * Mat3::Identity();
    softened = true;
  }
  return softened;
}

void report_contacts(const SurfacePatch& patch, const ContactSet& contacts, const ContactSolution& solution,
                     const std::array<Vec3, kMaxContacts>& point, double h, LocalFrame& frame,
                     SampleList& out) noexcept {
  Vec3 normal_sum = Vec3::Zero(), tangential_sum = Vec3::Zero();
  double largest = 0;
  for (int i = 0; i < contacts.count; ++i) {
    if (solution.mode[i] == ContactMode::free) continue;
    const Contact& contact = contacts.contacts[i];
    const Vec3 impulse = solution.impulse.segment<3>(3 * i), force = -impulse / h;
    const double f_n = force.dot(contact.normal);
    const Vec3 f_t = force - f_n * contact.normal;
    frame.force += force;
    frame.torque += (point[i] - frame.pose.x).cross(force);
    normal_sum += f_n * contact.normal;
    tangential_sum += f_t;
    frame.gap = frame.contacts == 0 ? contact.gap : std::min(frame.gap, contact.gap);
    ++frame.contacts;
    if (f_n > 0) frame.cone_ratio = std::max(frame.cone_ratio, f_t.norm() / f_n);
    if (f_n > largest) {
      largest = f_n;
      frame.triangle = frame.facet = patch.global_triangle[contact.triangle];
      frame.mode = solution.mode[i];
      frame.normal = contact.normal;
      frame.point = point[i];
      frame.flags &= ~static_cast<unsigned>(kLeftPatch);
      if (patch.on_rim[contact.triangle]) frame.flags |= kLeftPatch;
    }
    TickContact& sample = out.samples[out.count++];
    sample.triangle = patch.global_triangle[contact.triangle];
    sample.t = frame.t - h;
    sample.facet = -1;
    sample.bary = contact.bary;
    sample.impulse = impulse;
    sample.normal = contact.normal;
    sample.sticks = solution.mode[i] == ContactMode::stick;
    sample.point = point[i];
  }
  frame.f_n = normal_sum.norm();
  frame.f_t = tangential_sum.norm();
}

bool keep_finite(PreparedLocalModel& m, LocalFrame& frame, SampleList& samples) noexcept {
  if (frame.force.allFinite() && m.state.q.allFinite() && m.state.q_rate.allFinite()) return true;
  LocalFrame empty;
  empty.t = frame.t;
  empty.pose = frame.pose;
  empty.model_frame = frame.model_frame;
  empty.flags = frame.flags | kNotFinite;
  frame = empty;
  samples.count = 0;
  m.state.q.setZero();
  m.state.q_rate.setZero();
  return false;
}

}  // namespace kt
