// The tick of the consistent laws: contacts are constraints on the end of the step, moved by impulses.
// The surface point under the tool moves with it (docs/method.md#7-the-consistent-law).
#include <algorithm>
#include <cmath>

#include "haptics/tick/local_simulation.hpp"

namespace kt {
namespace {

constexpr int kGeometryIterations = 20;
constexpr double kSettled = 5e-7;       // [m] patch vertices at the guess and at the result agree: done
constexpr int kExchanged = 5;           // iterations after which places that pushed are kept
constexpr double kLeastRelaxed = 0.15;  // of the way from the guess to the result
constexpr double kMostRelaxed = 4;      // a point on a sharp edge: blended and face normal differ, plain steps creep
constexpr double kShortest = 1e-6;      // of the step: an impact this near to the end waits for the next tick

}  // namespace

/// A session may begin with the tool inside; one may run off the patch and get in there; and the slow side looks.
bool LocalSimulation::may_be_inside(int tool) const noexcept {
  const int way_out = model_->way_out[tool];
  const bool is_first = t_ < 1.5 * h_;
  return tools_[tool].is_off_patch || way_out >= 0 || (is_first && way_out == kNotLooked);
}

/// Where each tool touches at the start of the tick.
void LocalSimulation::start_tick() noexcept {
  PreparedLocalModel& m = *model_;
  LocalWorkspace& w = m.work;
  for (int k = 0; k < num_tools(); ++k) {
    TouchingTool& tool = tools_[k];
    std::ranges::fill(w.ignored[k], 0);
    tool.rest = tool.moving.sweep();
    const auto held = std::ranges::find(m.state.anchors, k, &Contact::tool);
    tool.start = held == m.state.anchors.end() ? -1 : held->triangle;
    const bool sees_more = has_new_patch_ || m.wide_index;
    if (tool.start < 0 && ((tool.is_off_patch && sees_more) || (has_new_patch_ && may_be_inside(k)))) {
      tool.start = find_overlap(k);
      tool.is_off_patch = false;
    }
    double& left = m.state.overlap[k].left;
    left = std::max(0.0, left - h_);
  }
  has_new_patch_ = false;
  w.impulse.setZero();
  w.impulse_weighted.setZero();
  w.x_event = w.x;
}

/// Body and tools back to the time of impact; what was held until then has acted until then.
/// @param toi  of the last event, as a share of the tick
void LocalSimulation::rewind_to(const Contact& impact, double& toi, std::span<LocalFrame> frames) noexcept {
  LocalWorkspace& w = model_->work;
  w.x_event += impact.toi * (w.x_end - w.x_event);
  for (TouchingTool& tool : tools_) tool.rest = rest_of(tool.rest, impact.toi);
  const double advanced = impact.toi * (1 - toi);
  w.impulse_weighted += advanced * w.impulse;
  toi += advanced;
  tools_[impact.tool].start = impact.triangle;
  ++frames[impact.tool].events;
}

/// The solver holds these as constraints of this tool: no collision pairs.
void LocalSimulation::ignore_around(const Contact& contact) noexcept {
  const SurfacePatch& facets = model_->surface.facets;
  for (int v : facets.triangles[contact.triangle])
    for (int t : facets.topology.triangles_of(v)) model_->work.ignored[contact.tool][t] = 1;
}

void LocalSimulation::step_constrained(std::span<LocalFrame> frames) noexcept {
  LocalWorkspace& w = model_->work;
  double toi = 0;  // of the last event
  start_tick();

  // Without contact: free motion up to the first impact, if there is one.
  if (std::ranges::none_of(tools_, [](const TouchingTool& tool) { return tool.start >= 0; })) {
    follow(w.u_free, w.u);
    w.x_end = w.x + h_ * w.u;
    Contact impact;
    if (!find_impact(impact)) return accept_free_motion();
    rewind_to(impact, toi, frames);
    frames[impact.tool].toi = toi;
    w.du.setZero();
  }
  hold_contacts(toi, frames);
  end_tick(toi, frames);
}

/// With contact: hold it for the rest of the step; what else is hit on the way ends the hold early.
void LocalSimulation::hold_contacts(double& toi, std::span<LocalFrame> frames) noexcept {
  LocalWorkspace& w = model_->work;
  for (bool is_held = false;; is_held = true) {
    const double h_left = (1 - toi) * h_;
    if (1 - toi < kShortest) {
      if (num_tools() == 1 || !is_held) contacts_.count = 0;  // else the other hand's go on
      w.x_end = w.x_event;
      return;
    }
    for (int k = 0; k < num_tools(); ++k)
      if (tools_[k].start >= 0) ignore_around({.triangle = tools_[k].start, .tool = k});
    resolve_contacts(h_left);
    for (const Contact& contact : contacts_) ignore_around(contact);
    std::array<ToolSweep, kMaxTools> whole;
    for (int k = 0; k < num_tools(); ++k) {
      whole[k] = tools_[k].moving.sweep();
      tools_[k].moving.move(tools_[k].rest);
    }
    Contact impact;
    const bool is_hit = find_impact(impact);
    for (int k = 0; k < num_tools(); ++k)
      tools_[k].moving.move(whole[k]);  // the contact solver asks for the speed of the whole tick
    if (!is_hit) return;
    int events = 0;
    for (int k = 0; k < num_tools(); ++k) events += frames[k].events;
    if (events == kMaxEvents) {
      add_flag(kEventsExhausted);
      return;
    }
    const bool is_first = tools_[impact.tool].start < 0;
    rewind_to(impact, toi, frames);
    if (is_first) frames[impact.tool].toi = toi;
  }
}

/// q+ = q + h v_free + sum of what each impulse moved, and the velocity that goes with it.
void LocalSimulation::end_tick(double toi, std::span<LocalFrame> frames) noexcept {
  PreparedLocalModel& m = *model_;
  LocalWorkspace& w = m.work;
  w.impulse_weighted += (1 - toi) * w.impulse;
  LocalState& s = m.state;
  const MatrixX &Y = m.dynamics->metric().Y, &C = m.dynamics->metric().C, &Y_end = m.dynamics->end_response();
  s.q.noalias() += h_ * w.v_free;
  s.q_rate = w.v_free_end;
  w.patch_motion += h_ * w.u_free;
  for (int i = 0; i < m.model.patch.num_vertices(); ++i) {
    if (const Vec3 moving = h_ * node(w.impulse_weighted, i); !moving.isZero(0)) {
      s.q.noalias() += Y.middleCols<3>(3 * i) * moving;
      w.patch_motion.noalias() += C.middleCols<3>(3 * i) * moving;
    }
    if (!node(w.impulse, i).isZero(0)) s.q_rate.noalias() += Y_end.middleCols<3>(3 * i) * node(w.impulse, i);
  }

  w.motion_of = s.q;

  s.anchors.count = 0;
  int kept = 0;  // contacts without an impulse are let go
  for (int i = 0; i < contacts_.count; ++i) {
    if (solution_.mode[i] == ContactMode::free) continue;
    contacts_.contacts[kept] = contacts_.contacts[i];
    s.impulse[kept] = solution_.impulse.segment<3>(3 * i);
    solution_.mode[kept] = solution_.mode[i];
    solution_.grip[kept] = solution_.grip[i];
    s.anchors.add(contacts_.contacts[kept++]);
  }
  contacts_.count = kept;
  settle_velocities();
  for (int k = 0; k < num_tools(); ++k) frames[k].force.setZero();
  for (int i = 0; i < kept; ++i) frames[contacts_.contacts[i].tool].force -= s.impulse[i] / h_;
  for (int k = 0; k < num_tools(); ++k) report_contacts(k, frames[k]);
}

/// Finds contacts where the surface will be, solves them, moves the surface accordingly, until both agree.
/// A light triangle tilts under the tool and moves the contact point across it, so the plain iteration can swing
/// between two answers for ever: Aitken's relaxation (Irons and Tuck 1969) takes the part of the way that the last two
/// steps suggest. Where that is not enough, as for a ball in a crevice, both places hold the tool (keep_pushing). What
/// is left of the gaps then is closed by close_gaps.
void LocalSimulation::resolve_contacts(double h_left) noexcept {
  PreparedLocalModel& m = *model_;
  LocalWorkspace& w = m.work;
  const auto is_extended = [](const TouchingTool& tool) {
    return tool.start >= 0 && tool.moving.shape().kind != ToolShape::Kind::point;
  };
  ContactSet before = m.state.anchors, pushing = before;
  for (int k = 0; k < num_tools(); ++k) {
    w.num_near[k] = -1;
    w.near[k].is_known = false;
  }
  double relaxed = 1;
  bool is_placed = false;  // x_guess is where du puts the surface
  for (int iteration = 0; iteration < kGeometryIterations; ++iteration) {
    if (!is_placed) place_surface(h_left, w.x_guess);
    if (iteration == 0 && std::ranges::any_of(tools_, is_extended)) index().refit(w.x_event, w.x_guess);
    find_contacts(w.x_guess);
    if (contacts_.count == kMaxContacts) add_flag(kContactsExhausted);
    drop_clear_places(pushing);
    if (iteration >= kExchanged) keep_pushing(before);
    fill_problem(h_left);
    warm_start(before);
    solver_->solve(problem_, solution_);
    residual_ = std::max(residual_, solution_.residual);
    before = contacts_;
    pushing.count = 0;
    for (int i = 0; i < contacts_.count; ++i) {
      m.state.impulse[i] = solution_.impulse.segment<3>(3 * i);
      if (solution_.mode[i] != ContactMode::free) pushing.add(contacts_.contacts[i]);
    }
    for (int i = contacts_.count - 1; i >= 0; --i)  // the first of each point tool
      if (TouchingTool& tool = tools_[contacts_.contacts[i].tool]; tool.moving.shape().kind == ToolShape::Kind::point)
        tool.start = contacts_.contacts[i].triangle;

    w.du_guess = w.du;
    spread_impulses();
    place_surface(h_left, w.x_end);
    w.step_before.swap(w.step);
    w.step = w.du - w.du_guess;
    const bool is_settled = h_left * w.step.lpNorm<Eigen::Infinity>() < kSettled;
    if (is_settled && close_gaps(h_left)) return;
    is_placed = !is_settled;  // else close_gaps has moved the surface's end
    if (is_settled) {
      relaxed = 1;
    } else if (iteration > 0) {
      const double turn = (w.step - w.step_before).squaredNorm();
      const double suggested = turn > 0 ? -relaxed * w.step_before.dot(w.step - w.step_before) / turn : 1.0;
      relaxed = std::clamp(suggested, kLeastRelaxed, kMostRelaxed);
    }
    if (iteration + 1 == kGeometryIterations) break;
    w.du = w.du_guess + relaxed * w.step;
    if (is_placed) w.x_guess += relaxed * (w.x_end - w.x_guess);  // it is linear in du
  }
  close_gaps(h_left);
}

/// Where the surface is after a rest of the step with the motion that is known so far.
void LocalSimulation::place_surface(double h_left, VectorX& out) noexcept {
  LocalWorkspace& w = model_->work;
  w.motion = w.u_free + w.du;
  follow(w.motion, w.u);
  out = w.x_event + h_left * w.u;
}

void LocalSimulation::couple_contacts(const MatrixX& C, ContactMatrix& out) noexcept {
  const int c = contacts_.count;
  std::array<NodeWeights, kMaxContacts> moves;
  for (int i = 0; i < c; ++i)
    moves[i] = model_->surface.moved_by(contacts_.contacts[i].triangle, contacts_.contacts[i].bary);
  out.resize(3 * c, 3 * c);
  couple_points(C, {moves.data(), static_cast<std::size_t>(c)}, model_->work.coupling, out);
}

/// A contact is softened, and flagged, where nothing can move.
void LocalSimulation::fill_problem(double h_left) noexcept {
  const PreparedLocalModel& m = *model_;
  const LocalWorkspace& w = m.work;
  const MatrixX& C = m.dynamics->metric().C;
  const int c = contacts_.count;
  const double softest = softest_contact(m) * h_ / h_left;
  problem_.count = c;
  problem_.h = h_;
  problem_.velocity.resize(3 * c);
  couple_contacts(C, problem_.W);
  for (int i = 0; i < c; ++i) {
    const Contact& contact = contacts_.contacts[i];
    const auto motion = [&](const VectorX& patch) { return m.surface.at(patch, contact.triangle, contact.bary); };
    const Vec3& n = contact.normal;
    problem_.normal[i] = n;
    problem_.sliding[i] = m.state.sliding[contact.tool];
    problem_.triangle[i] = m.surface.facets.global_triangle[contact.triangle];
    // The gap there would be without contact impulses, to first order.
    const double gap_free = contact.gap + m.state.overlap[contact.tool].allowed() + h_left * n.dot(motion(w.du));
    const Vec3 place = place_of(contact, w.x_guess);
    const Vec3 relative = motion(w.u_free) - tool_of(contact).moving.way(place) / h_;
    problem_.velocity.segment<3>(3 * i) = relative - n.dot(relative) * n - gap_free / h_left * n;
    auto own = problem_.W.block<3, 3>(3 * i, 3 * i);
    if (own.trace() < 3 * softest) {
      own += softest * Mat3::Identity();
      tools_[contact.tool].flags |= kRigidContact;
    }
  }
}

/// Impulses of all contacts at the patch vertices, and the patch motion that they cause.
void LocalSimulation::spread_impulses() noexcept {
  PreparedLocalModel& m = *model_;
  LocalWorkspace& w = m.work;
  w.impulse.setZero();
  for (int i = 0; i < contacts_.count; ++i)
    m.surface.add_at(w.impulse, contacts_.contacts[i].triangle, contacts_.contacts[i].bary,
                     solution_.impulse.segment<3>(3 * i));
  w.du.setZero();
  const MatrixX& C = m.dynamics->metric().C;
  for (int i = 0; i < m.model.patch.num_vertices(); ++i)
    if (!node(w.impulse, i).isZero(0)) w.du.noalias() += C.middleCols<3>(3 * i) * node(w.impulse, i);
}

}  // namespace kt
