#include "haptics/tick/local_simulation.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "collision/held/first_contact.hpp"

namespace kt {
namespace {

constexpr double kPushOut = 0.06;       // [s] a tool that was found inside is out after it,
constexpr double kPushSpeed = 0.1;      // [m/s] or as much later as it takes at this mean speed
constexpr double kLeastLimited = 1e-4;  // [m] a smaller overlap is a new model's difference, which the blend fades

/// How much longer than usual the force fades over from a model that was in use for that time [s]: the body is far from
/// where it was linearized.
double fade_after(double in_use) noexcept {
  constexpr double kUsual = 0.05, kFaded = 0.03, kMost = 8;
  return in_use <= kUsual ? 1 : std::min(kMost, in_use / kFaded);
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

int count_of(const ContactSet& contacts, int tool) noexcept {
  return static_cast<int>(
      std::count_if(contacts.begin(), contacts.end(), [&](const Contact& c) { return c.tool == tool; }));
}

}  // namespace

LocalSimulation::LocalSimulation(const ToolShape& tool, double h, std::unique_ptr<ContactSolver> solver, double blend)
    : LocalSimulation(std::span<const ToolShape>(&tool, 1), h, std::move(solver), blend) {}

LocalSimulation::LocalSimulation(std::span<const ToolShape> tools, double h, std::unique_ptr<ContactSolver> solver,
                                 double blend)
    : h_(h), solver_(std::move(solver)) {
  KT_ASSERT(!tools.empty() && tools.size() <= static_cast<std::size_t>(kMaxTools));
  for (const ToolShape& tool : tools) tools_.emplace_back(tool, h, blend);
  problem_.velocity.setZero(3 * kMaxContacts);
  problem_.W.setZero(3 * kMaxContacts, 3 * kMaxContacts);
  solution_.impulse.setZero(0);
}

/// Those that changed while the body was touched come with the model.
void LocalSimulation::take_settings() noexcept {
  solver_->use(model_->friction.get());
  for (int k = 0; k < num_tools(); ++k) {
    const double radius = model_->tool_radius[k];
    if (radius < 0 || radius == tools_[k].moving.shape().radius) continue;
    tools_[k].moving.set_radius(radius);
    tools_[k].reach = tool_reach(tools_[k].moving.shape());
  }
}

std::unique_ptr<PreparedLocalModel> LocalSimulation::adopt(std::unique_ptr<PreparedLocalModel> next) noexcept {
  std::swap(model_, next);
  take_settings();
  has_new_patch_ = true;
  if (!next) {
    motion_ = make_local_motion(static_cast<int>(model_->recovered_row.size()));
    return next;
  }
  PreparedLocalModel& now = *model_;
  PreparedLocalModel& old = *next;
  const double in_use = h_ * (now.linearized_tick - old.linearized_tick);  // [s]
  for (int k = 0; k < num_tools(); ++k)
    tools_[k].blend.begin(now.caught_up ? now.replayed_force[k] : std::nullopt, fade_after(in_use));
  if (now.caught_up) {
    for (int k = 0; k < num_tools(); ++k)
      if (count_of(now.state.anchors, k) == 0 && count_of(old.state.anchors, k) > 0) tools_[k].flags |= kLostAnchor;
    sweep_refresh(old);
    return next;
  }

  record_motion(old, 0, motion_);
  carry_motion(motion_, now);
  now.state.anchors.count = 0;
  if (t_ > 0) cover_tools(true, 0);
  for (int i = 0; i < old.state.anchors.count; ++i) {
    Contact anchor = old.state.anchors.contacts[i];
    anchor.triangle = now.local_facet(old.surface.global_facet(anchor.triangle));
    if (anchor.triangle < 0) {
      tools_[anchor.tool].flags |= kLostAnchor;
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
  std::array<bool, kMaxTools> is_free{};
  for (int k = 0; k < num_tools(); ++k) is_free[k] = count_of(m.state.anchors, k) == 0;
  if (t_ == 0 || std::ranges::count(is_free, true) == 0 || solver_->deformation() != Deformation::none) return;
  record_motion(old, 0, motion_);
  near_apron_ = m.wide_index != nullptr;
  cover_tools(true, 0);
  m.recover_patch(m.state.q, w.motion);
  w.motion += m.model.x0.head(w.motion.size());
  m.surface.follow(w.motion, w.x);
  m.surface.place_apron(w.motion, w.x);
  w.x_end = w.x;
  for (int i = 0; i < m.model.patch.num_vertices(); ++i)
    if (const int row = motion_.row[m.model.patch.global_node[i]]; row >= 0) node(w.motion, i) = node(motion_.x, row);
  m.surface.follow(w.motion, w.x_event);
  place_apron_before(old, motion_, m);
  index().refit(w.x_event, w.x_end);
  for (int k = 0; k < num_tools(); ++k) {
    if (!is_free[k]) continue;
    MovingTool& tool = tools_[k].moving;
    const ToolSweep last = tool.sweep();
    tool.move({last.x_t1, last.x_t1, last.r_t1, last.r_t1});
    std::ranges::fill(w.ignored[k], 0);
    Contact touched;
    if (!find_impact_of(k, touched) || find_overlap(k) < 0) continue;
    m.state.impulse[m.state.anchors.count].setZero();
    touched.core = last.x_t1;
    m.state.anchors.add(touched);
  }
}

void LocalSimulation::set_force(const VectorX& force) noexcept {
  LocalModel& m = model_->model;
  const LocalState& s = model_->state;
  m.f0 = force;
  m.f0.noalias() += m.stiffness * s.q;
  m.f0.noalias() += m.damping * s.q_rate;
}

/// The basis is the largest thing that a tick reads, so it is read once, for the velocities: where the last tick ended
/// the motion is known from them, to rounding.
void LocalSimulation::recover_patch_motion() noexcept {
  PreparedLocalModel& m = *model_;
  LocalWorkspace& w = m.work;
  if (w.motion_of == m.state.q) return;
  m.recover_patch(m.state.q, w.patch_motion);
  w.motion_of = m.state.q;
}

void LocalSimulation::find_free_motion() noexcept {
  PreparedLocalModel& m = *model_;
  LocalWorkspace& w = m.work;
  recover_patch_motion();
  w.motion = w.patch_motion;
  const double moved = w.motion.lpNorm<Eigen::Infinity>();
  near_apron_ = comes_near_apron(moved);
  if (near_apron_) cover_tools(false, moved);
  w.motion += m.model.x0.head(w.motion.size());
  m.surface.follow(w.motion, w.x);
  if (near_apron_) m.surface.place_apron(w.motion, w.x);
  m.dynamics->free_motion(m.state.q, m.state.q_rate, w.v_free, w.v_free_end);
  m.recover_patch(w.v_free, w.u_free);
}

/// Whether a tool may meet the patch's rim or what is beyond in this tick; the rest of the surface costs its time only
/// then.
/// @param moved  most that a coordinate of the patch has moved since the linearization [m]
bool LocalSimulation::comes_near_apron(double moved) const noexcept {
  constexpr double kMargin = 0.1;  // of the tool's reach: more than contacts are looked for within
  const PreparedLocalModel& m = *model_;
  if (!m.wide_index) return false;
  for (int k = 0; k < num_tools(); ++k) {
    const ToolSweep& sweep = tools_[k].moving.sweep();
    const double way = (sweep.x_t1 - sweep.x_t0).norm();
    const double away = (sweep.x_t0 - m.clear_from[k]).norm() + 2 * way + 2 * moved;  // a diagonal is 1.8 coordinates
    if (away + (1 + kMargin) * tools_[k].reach >= m.clear[k]) return true;
  }
  return false;
}

/// The part of the body's surface that the tick looks at goes with the tools.
/// @param at_end  of their sweeps, which are over; else all along these
/// @param moved   as above
void LocalSimulation::cover_tools(bool at_end, double moved) noexcept {
  constexpr double kMargin = 0.1;  // of the tool's reach, as above
  PreparedLocalModel& m = *model_;
  if (!m.apron || m.apron->has_all()) return;
  std::array<Vec3, kMaxTools> places;
  bool is_covered = true;
  for (int k = 0; k < num_tools(); ++k) {
    const ToolSweep& sweep = tools_[k].moving.sweep();
    places[k] = at_end ? sweep.x_t1 : sweep.x_t0;
    const double way = at_end ? 0 : (sweep.x_t1 - sweep.x_t0).norm();
    const double need = (1 + kMargin) * tools_[k].reach + 2 * way + 2 * moved + m.apron->motion().lowered;
    is_covered = is_covered && m.apron->covers(k, places[k], need);
  }
  if (!is_covered) move_apron(m, {places.data(), tools_.size()});
}

/// Velocities of the surface from those of the patch's vertices.
void LocalSimulation::follow(const VectorX& patch, VectorX& out) noexcept {
  model_->surface.follow(patch, out);
  if (near_apron_) model_->surface.follow_apron(patch, out);
}

/// The earliest of all tools, each along the sweep that it was last taken along; of equal times that of the first tool.
bool LocalSimulation::find_impact(Contact& impact) noexcept {
  index().refit(model_->work.x_event, model_->work.x_end);
  bool is_hit = false;
  for (int k = 0; k < num_tools(); ++k) {
    Contact of_tool;
    if (!find_impact_of(k, of_tool) || (is_hit && of_tool.toi >= impact.toi)) continue;
    impact = of_tool;
    is_hit = true;
  }
  return is_hit;
}

/// Of one tool, with the index at hand.
bool LocalSimulation::find_impact_of(int tool, Contact& impact) noexcept {
  PreparedLocalModel& m = *model_;
  const MovingTriangles surface{m.surface.facets.triangles, m.work.x_event, m.work.x_end};
  const auto found = find_first_contact(index(), surface, tools_[tool].moving, m.work.ignored[tool], m.work.candidates);
  if (!found) return false;
  impact = *found;
  impact.tool = tool;
  return true;
}

void LocalSimulation::accept_free_motion() noexcept {
  LocalState& s = model_->state;
  LocalWorkspace& w = model_->work;
  const bool is_known = w.motion_of == s.q;
  s.q.noalias() += h_ * w.v_free;
  s.q_rate = w.v_free_end;
  if (is_known) {
    w.patch_motion += h_ * w.u_free;
    w.motion_of = s.q;
  }
  s.anchors.count = 0;
  w.du.setZero();
}

LocalFrame LocalSimulation::step(const ToolSweep& sweep) noexcept {
  LocalFrame frame;
  step_tools({&sweep, 1}, {&frame, 1});
  return frame;
}

void LocalSimulation::step_tools(std::span<const ToolSweep> sweeps, std::span<LocalFrame> frames) noexcept {
  num_samples_ = 0;
  residual_ = 0;
  t_ += h_;
  for (int k = 0; k < num_tools(); ++k) {
    frames[k] = {};
    frames[k].t = t_;
    frames[k].pose = {sweeps[k].x_t1, sweeps[k].r_t1};
    frames[k].model_frame = model_->model.frame;
    tools_[k].moving.move(sweeps[k]);
  }
  find_free_motion();
  if (solver_->deformation() == Deformation::none)
    step_constrained(frames);
  else
    step_geometric(sweeps[0], frames[0]);

  LocalState& s = model_->state;
  bool is_finite = s.q.allFinite() && s.q_rate.allFinite();
  for (int k = 0; k < num_tools(); ++k) is_finite = is_finite && frames[k].force.allFinite();
  if (!is_finite) {
    s.q.setZero();  // back to the linearization pose: the last state known to be good
    s.q_rate.setZero();
    s.anchors.count = 0;
    num_samples_ = 0;
    for (int k = 0; k < num_tools(); ++k) {
      frames[k].force.setZero();
      frames[k].mode = ContactMode::free;
    }
    add_flag(kNotFinite);
  }
  for (int k = 0; k < num_tools(); ++k) {
    shape_force(k, frames[k]);
    s.sliding[k] = frames[k].mode == ContactMode::frictional_slide;
    frames[k].flags = std::exchange(tools_[k].flags, 0u);
    frames[k].residual = residual_;
  }
}

/// What leaves for the hand: no step at a refresh or while the body is pushed off the tool, and no fall where the tool
/// ran off the patch.
void LocalSimulation::shape_force(int tool, LocalFrame& frame) noexcept {
  TouchingTool& t = tools_[tool];
  const bool touches = frame.mode != ContactMode::free;
  t.is_off_patch = !touches && (t.is_off_patch || t.was_on_rim);
  t.was_on_rim = touches && (t.flags & kLeftPatch);
  if (t.is_off_patch) t.flags |= kLeftPatch;
  double others = 0;
  for (int k = 0; k < num_tools(); ++k)
    if (k != tool) others += tools_[k].blend.work();
  const ToolSweep& sweep = t.moving.sweep();
  frame.force = t.blend.apply(frame.force, touches, t.is_off_patch, sweep.x_t1 - sweep.x_t0, others);
  if (t.push.is_on() && touches) t.flags |= kPushedOut;
  frame.force = t.push.apply(frame.force, touches, model_->state.overlap[tool].left > 0);
}

/// The facet that a tool has got into unseen at the start of its sweep, as where neither patch nor apron reached; -1:
/// none. Where the slow side has found its way out, it is that one or near it. It is pushed out over some ticks: at
/// once would be a blow.
int LocalSimulation::find_overlap(int tool) noexcept {
  PreparedLocalModel& m = *model_;
  TouchingTool& t = tools_[tool];
  if (!near_apron_) m.surface.place_apron(m.work.motion, m.work.x);
  const SurfacePatch& facets = m.surface.facets;
  const int way_out = m.way_out[tool] < 0 ? -1 : m.local_facet(m.way_out[tool] * m.surface.facets_per_triangle());
  Contact deepest;
  deepest.gap = t.moving.shape().radius;
  for (const Vec3& corner : t.moving.corners_t0()) {
    const Contact nearest = way_out < 0 ? nearest_point_contact(facets, m.work.x, corner)
                                        : track_point_contact(facets, m.work.x, corner, way_out);
    if (nearest.gap < deepest.gap) deepest = nearest;
  }
  if (deepest.triangle < 0) return -1;
  if (num_tools() > 1) {  // far away on the other side of a patch that is not its own: find_contact_sites()
    const auto nodes = m.work.x.head(3 * facets.num_vertices()).reshaped(3, facets.num_vertices());
    if (-deepest.gap > (nodes.rowwise().maxCoeff() - nodes.rowwise().minCoeff()).norm()) return -1;
  }
  const double overlap = t.moving.shape().radius - deepest.gap, time = std::max(kPushOut, overlap / kPushSpeed);
  model_->state.overlap[tool] = {overlap, time, time};
  if (overlap > kLeastLimited) t.push.begin();
  return deepest.triangle;
}

double Overlap::allowed() const noexcept {
  if (!(left > 0)) return 0;
  const double share = left / time;
  return start * share * share * (3 - 2 * share);
}

/// Where a contact is on the surface at x.
Vec3 LocalSimulation::place_of(const Contact& contact, const VectorX& x) const noexcept {
  const SurfacePatch& facets = model_->surface.facets;
  if (!facets.is_curved) return contact.core - (tool_of(contact).moving.shape().radius + contact.gap) * contact.normal;
  Vec3 out = Vec3::Zero();
  for (int c = 0; c < 3; ++c) out += contact.bary[c] * node(x, facets.triangles[contact.triangle][c]);
  return out;
}

/// Splits the tick's impulses of one tool into what is reported and what goes to the global side.
void LocalSimulation::report_contacts(int tool, LocalFrame& frame) noexcept {
  const ContactSurface& surface = model_->surface;
  const SurfacePatch& facets = surface.facets;
  Vec3 normal_sum = Vec3::Zero(), tangential_sum = Vec3::Zero();
  double largest = 0;
  frame.contacts = 0;
  frame.gap = std::numeric_limits<double>::infinity();
  for (int i = 0; i < contacts_.count; ++i) {
    const Contact& contact = contacts_.contacts[i];
    if (contact.tool != tool) continue;
    const Vec3 impulse = model_->state.impulse[i], force = -impulse / h_;
    const double f_n = force.dot(contact.normal);
    const Vec3 f_t = force - f_n * contact.normal;
    normal_sum += f_n * contact.normal;
    tangential_sum += f_t;
    ++frame.contacts;
    frame.gap = std::min(frame.gap, contact.gap);
    if (f_n > 0) frame.cone_ratio = std::max(frame.cone_ratio, f_t.norm() / f_n);
    const Vec3 point = place_of(contact, model_->work.x_end);
    frame.torque += (point - frame.pose.x).cross(force);
    if (f_n > largest) {
      largest = f_n;
      frame.triangle = facets.global_triangle[contact.triangle];
      frame.facet = surface.global_facet(contact.triangle);
      frame.mode = solution_.mode[i];
      frame.normal = contact.normal;
      frame.point = point;
      if (facets.on_rim[contact.triangle]) tools_[tool].flags |= kLeftPatch;
      if (surface.is_apron(contact.triangle)) tools_[tool].flags |= kOnApron;
    }
    TickContact& sample = samples_[num_samples_++];
    sample.triangle = facets.global_triangle[contact.triangle];
    sample.t = t_ - h_;
    sample.facet = surface.goes_with_apron(contact.triangle) ? -1 : contact.triangle;
    sample.bary = contact.bary;
    sample.impulse = impulse;
    sample.normal = contact.normal;
    sample.sticks = solution_.mode[i] == ContactMode::stick;
    sample.point = point;
    sample.tool = tool;
  }
  frame.f_n = normal_sum.norm();
  frame.f_t = tangential_sum.norm();
}

}  // namespace kt
