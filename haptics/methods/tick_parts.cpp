#include "haptics/methods/tick_parts.hpp"

namespace kt {

std::unique_ptr<ContactSolver> make_cone_solver(const std::string& method, const HapticMethodOptions& options) {
  auto solver = make_contact_solver(options.law, options.friction);
  if (solver->deformation() != Deformation::none)
    throw InputError(text("local.method \"", method, "\" needs contact.law \"coulomb\", not \"", options.law,
                          "\": it has no place for the paper's operators"));
  return solver;
}

void find_free_motion(PreparedLocalModel& m) noexcept {
  LocalWorkspace& w = m.work;
  w.x = m.model.x0.head(w.x.size());
  w.x.noalias() += m.patch_basis * m.state.q;
  m.dynamics->free_velocity(m.state.q, m.state.q_rate, w.v_free);
  w.u_free.noalias() = m.patch_basis * w.v_free;
}

void step_body(PreparedLocalModel& m) noexcept {
  LocalWorkspace& w = m.work;
  LocalState& s = m.state;
  s.q_rate = w.v_free;
  const MatrixX& Y = m.dynamics->metric().Y;
  for (int i = 0; i < m.model.patch.num_vertices(); ++i)
    if (!node(w.impulse, i).isZero(0)) s.q_rate.noalias() += Y.middleCols<3>(3 * i) * node(w.impulse, i);
  s.q.noalias() += m.dynamics->h() * s.q_rate;
  w.x_end = m.model.x0.head(w.x_end.size());
  w.x_end.noalias() += m.patch_basis * s.q;
}

void add_impulse(PreparedLocalModel& m, int triangle, const Vec3& bary, const Vec3& impulse) noexcept {
  const Triangle& t = m.model.patch.triangles[triangle];
  for (int c = 0; c < 3; ++c) node(m.work.impulse, t[c]) += bary[c] * impulse;
}

void carry_over(PreparedLocalModel& old, PreparedLocalModel& now) noexcept {
  LocalWorkspace &from = old.work, &to = now.work;
  from.x_recovered = old.model.x0;
  from.x_recovered.noalias() += old.model.basis * old.state.q;
  from.v_recovered.noalias() = old.model.basis * old.state.q_rate;
  for (int i = 0; i < static_cast<int>(now.model.recovered_node.size()); ++i) {
    const int row = old.recovered_row[now.model.recovered_node[i]];
    node(to.x_recovered, i).setZero();
    node(to.v_recovered, i).setZero();
    if (row < 0) continue;
    node(to.x_recovered, i) = node(from.x_recovered, row) - node(now.model.x0, i);
    node(to.v_recovered, i) = node(from.v_recovered, row) - node(now.model.v0, i);
  }
  now.state.q.noalias() = now.model.lift * to.x_recovered;
  now.state.q_rate = now.model.q_rate0;
  now.state.q_rate.noalias() += now.model.lift_rate * to.v_recovered;
}

bool soften(ContactProblem& problem) noexcept {
  constexpr double kStiffest = 1e6;  // [N/m] as in LocalSimulation
  const double softest = 1 / (kStiffest * problem.h * problem.h);
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
    normal_sum += f_n * contact.normal;
    tangential_sum += f_t;
    frame.gap = frame.contacts == 0 ? contact.gap : std::min(frame.gap, contact.gap);
    ++frame.contacts;
    if (f_n > 0) frame.cone_ratio = std::max(frame.cone_ratio, f_t.norm() / f_n);
    if (f_n > largest) {
      largest = f_n;
      frame.triangle = patch.global_triangle[contact.triangle];
      frame.mode = solution.mode[i];
      frame.normal = contact.normal;
      frame.flags &= ~static_cast<unsigned>(kLeftPatch);
      if (patch.on_rim[contact.triangle]) frame.flags |= kLeftPatch;
    }
    ContactSample& sample = out.samples[out.count++];
    sample.t = frame.t - h;
    sample.bary = contact.bary;
    sample.impulse = impulse;
    sample.normal = contact.normal;
    sample.sticks = solution.mode[i] == ContactMode::stick;
    sample.point = point[i];
    for (int c = 0; c < 3; ++c) sample.nodes[c] = patch.global_node[patch.triangles[contact.triangle][c]];
  }
  frame.f_n = normal_sum.norm();
  frame.f_t = tangential_sum.norm();
}

bool keep_finite(PreparedLocalModel& m, LocalFrame& frame, SampleList& samples) noexcept {
  if (frame.force.allFinite() && m.state.q.allFinite() && m.state.q_rate.allFinite()) return true;
  LocalFrame empty;
  empty.t = frame.t;
  empty.tool = frame.tool;
  empty.model_frame = frame.model_frame;
  empty.flags = frame.flags | kNotFinite;
  frame = empty;
  samples.count = 0;
  m.state.q.setZero();
  m.state.q_rate.setZero();
  return false;
}

}  // namespace kt
