#include "haptics/local_simulation.hpp"

#include <algorithm>
#include <cmath>

#include "collision/first_contact.hpp"

namespace kt {
namespace {

constexpr double kPushOut = 0.06;  // [s] a tool that was found inside is out after it

}  // namespace

LocalSimulation::LocalSimulation(const ToolShape& tool, double h, std::unique_ptr<ContactSolver> solver, double blend)
    : tool_(tool), h_(h), solver_(std::move(solver)), blend_(h, blend) {
  problem_.velocity.setZero(3 * kMaxContacts);
  problem_.W.setZero(3 * kMaxContacts, 3 * kMaxContacts);
  solution_.impulse.setZero(0);
}

std::unique_ptr<PreparedLocalModel> LocalSimulation::adopt(std::unique_ptr<PreparedLocalModel> next) noexcept {
  std::swap(model_, next);
  has_new_patch_ = true;
  if (!next) {
    motion_ = make_local_motion(static_cast<int>(model_->recovered_row.size()));
    return next;
  }
  PreparedLocalModel& now = *model_;
  PreparedLocalModel& old = *next;
  blend_.begin();
  if (now.caught_up) {
    if (now.state.anchors.count == 0 && old.state.anchors.count > 0) flags_ |= kLostAnchor;
    sweep_refresh(old);
    return next;
  }

  record_motion(old, 0, motion_);
  carry_motion(motion_, now);
  now.state.anchors.count = 0;
  for (int i = 0; i < old.state.anchors.count; ++i) {
    Contact anchor = old.state.anchors.contacts[i];
    anchor.triangle = now.local_facet(old.surface.global_facet(anchor.triangle));
    if (anchor.triangle < 0) {
      flags_ |= kLostAnchor;
      continue;
    }
    now.state.impulse[now.state.anchors.count] = old.state.impulse[i];
    now.state.anchors.add(anchor);
  }
  now.state.sliding = old.state.sliding;
  sweep_refresh(old);
  return next;
}

/// A refresh moves the surface, from where the old model had it to where the new one does, in no time. A tool that it
/// goes through is touched from then on, and pushed out over some ticks.
void LocalSimulation::sweep_refresh(const PreparedLocalModel& old) noexcept {
  PreparedLocalModel& m = *model_;
  LocalWorkspace& w = m.work;
  if (t_ == 0 || m.state.anchors.count > 0 || solver_->deformation() != Deformation::none) return;
  record_motion(old, 0, motion_);
  m.recover_patch(m.state.q, w.motion);
  w.motion += m.model.x0.head(w.motion.size());
  m.surface.follow(w.motion, w.x);
  w.x_end = w.x;
  for (int i = 0; i < m.model.patch.num_vertices(); ++i)
    if (const int row = motion_.row[m.model.patch.global_node[i]]; row >= 0) node(w.motion, i) = node(motion_.x, row);
  m.surface.follow(w.motion, w.x_event);
  const ToolSweep& last = tool_.sweep();
  tool_.move({last.x_t1, last.x_t1, last.r_t1, last.r_t1});
  std::fill(w.ignored.begin(), w.ignored.end(), 0);
  Contact touched;
  if (!find_impact(touched) || find_overlap() < 0) return;
  m.state.impulse[0].setZero();
  touched.core = last.x_t1;
  m.state.anchors.add(touched);
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
  m.recover_patch(m.state.q, w.motion);
  w.motion += m.model.x0.head(w.motion.size());
  m.surface.follow(w.motion, w.x);
  m.dynamics->free_motion(m.state.q, m.state.q_rate, w.v_free, w.v_free_end);
  m.recover_patch(w.v_free, w.u_free);
}

/// Of the tool along the sweep that it was last taken along.
bool LocalSimulation::find_impact(Contact& impact) noexcept {
  PreparedLocalModel& m = *model_;
  m.index->refit(m.work.x_event, m.work.x_end);
  const MovingTriangles surface{m.surface.facets.triangles, m.work.x_event, m.work.x_end};
  const auto found = find_first_contact(*m.index, surface, tool_, m.work.ignored, m.work.candidates);
  if (found) impact = *found;
  return found.has_value();
}

void LocalSimulation::accept_free_motion() noexcept {
  LocalState& s = model_->state;
  s.q.noalias() += h_ * model_->work.v_free;
  s.q_rate = model_->work.v_free_end;
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

  tool_.move(sweep);
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
  shape_force(sweep, frame);
  s.sliding = frame.mode == ContactMode::frictional_slide;
  frame.flags = flags_;
  flags_ = 0;
  return frame;
}

/// What leaves for the hand: no step at a refresh, and no fall where the tool ran off the patch.
void LocalSimulation::shape_force(const ToolSweep& sweep, LocalFrame& frame) noexcept {
  const bool touches = frame.mode != ContactMode::free;
  is_off_patch_ = !touches && (is_off_patch_ || was_on_rim_);
  was_on_rim_ = touches && (flags_ & kLeftPatch);
  if (is_off_patch_) flags_ |= kLeftPatch;
  frame.force = blend_.apply(frame.force, touches, is_off_patch_, sweep.x_t1 - sweep.x_t0);
}

/// The patch triangle that a tool has got into unseen at the start of its sweep, as while the patch did not reach
/// there; -1: none. It is pushed out over some ticks: at once would be a blow.
int LocalSimulation::find_overlap() noexcept {
  const PreparedLocalModel& m = *model_;
  Contact deepest;
  deepest.gap = tool_.shape().radius;
  for (const Vec3& corner : tool_.corners_t0())
    if (const Contact nearest = nearest_point_contact(m.surface.facets, m.work.x, corner); nearest.gap < deepest.gap)
      deepest = nearest;
  if (deepest.triangle < 0) return -1;
  overlap_start_ = tool_.shape().radius - deepest.gap;
  overlap_left_ = kPushOut;
  return deepest.triangle;
}

/// Starts and ends with no speed, so that the push is felt and its ends are not.
double LocalSimulation::allowed_overlap() const noexcept {
  const double left = overlap_left_ / kPushOut;
  return overlap_start_ * left * left * (3 - 2 * left);
}

/// Where a contact is on the surface at x.
Vec3 LocalSimulation::place_of(const Contact& contact, const VectorX& x) const noexcept {
  const SurfacePatch& facets = model_->surface.facets;
  if (!facets.is_curved) return contact.core - (tool_.shape().radius + contact.gap) * contact.normal;
  Vec3 out = Vec3::Zero();
  for (int c = 0; c < 3; ++c) out += contact.bary[c] * node(x, facets.triangles[contact.triangle][c]);
  return out;
}

/// Splits the tick's impulses into what is reported and what goes to the global side.
void LocalSimulation::report_contacts(LocalFrame& frame) noexcept {
  const ContactSurface& surface = model_->surface;
  const SurfacePatch& facets = surface.facets;
  Vec3 normal_sum = Vec3::Zero(), tangential_sum = Vec3::Zero();
  double largest = 0;
  frame.contacts = contacts_.count;
  frame.gap = contacts_.count ? contacts_.contacts[0].gap : 0;
  for (int i = 0; i < contacts_.count; ++i) {
    const Contact& contact = contacts_.contacts[i];
    const Vec3 impulse = model_->state.impulse[i], force = -impulse / h_;
    const double f_n = force.dot(contact.normal);
    const Vec3 f_t = force - f_n * contact.normal;
    normal_sum += f_n * contact.normal;
    tangential_sum += f_t;
    frame.gap = std::min(frame.gap, contact.gap);
    if (f_n > 0) frame.cone_ratio = std::max(frame.cone_ratio, f_t.norm() / f_n);
    const Vec3 point = place_of(contact, model_->work.x_end);
    frame.torque += (point - frame.tool).cross(force);
    if (f_n > largest) {
      largest = f_n;
      frame.triangle = facets.global_triangle[contact.triangle];
      frame.facet = surface.global_facet(contact.triangle);
      frame.mode = solution_.mode[i];
      frame.normal = contact.normal;
      frame.point = point;
      if (facets.on_rim[contact.triangle]) flags_ |= kLeftPatch;
    }
    ContactSample& sample = samples_[num_samples_++];
    sample.triangle = facets.global_triangle[contact.triangle];
    sample.t = t_ - h_;
    sample.bary = weights_in_triangle(contact.triangle % surface.facets_per_triangle(), surface.levels, contact.bary);
    sample.moves = surface.moved_by(model_->model.patch, contact.triangle, contact.bary);
    sample.impulse = impulse;
    sample.normal = contact.normal;
    sample.sticks = solution_.mode[i] == ContactMode::stick;
    sample.point = point;
  }
  frame.f_n = normal_sum.norm();
  frame.f_t = tangential_sum.norm();
}

}  // namespace kt
