// The tick of the consistent laws: contacts are constraints on the end of the step, moved by impulses.
// The surface point under the tool moves with it (method.md section 5, notes 3 and 4).
#include <algorithm>
#include <cmath>

#include "collision/tool_contacts.hpp"
#include "haptics/local_simulation.hpp"

namespace kt {
namespace {

constexpr int kGeometryIterations = 20;
constexpr double kSettled = 5e-7;       // [m] patch vertices at the guess and at the result agree: done
constexpr double kLeastRelaxed = 0.15;  // of the way from the guess to the result
constexpr double kMostRelaxed = 4;      // a point on a sharp edge: blended and face normal differ, plain steps creep
constexpr double kHeaviest = 1;         // [kg] a contact with an immovable part feels this mass: 1e6 N/m at 1 kHz
constexpr double kShortest = 1e-6;      // of the step: an impact this near to the end waits for the next tick

}  // namespace

void LocalSimulation::step_constrained(const ToolSweep& sweep, LocalFrame& frame) noexcept {
  PreparedLocalModel& m = *model_;
  LocalWorkspace& w = m.work;
  std::fill(w.ignored.begin(), w.ignored.end(), 0);
  w.impulse.setZero();
  w.impulse_weighted.setZero();
  w.x_event = w.x;
  double toi = 0;  // of the last event
  ToolSweep rest = sweep;
  int start = m.state.anchors.count ? m.state.anchors.contacts[0].triangle : -1;
  const bool is_first = t_ < 1.5 * h_;  // a session may begin with the tool inside
  if (start < 0 && has_new_patch_ && (is_off_patch_ || is_first)) {
    start = find_overlap();
    is_off_patch_ = false;
  }
  has_new_patch_ = false;
  overlap_left_ = std::max(0.0, overlap_left_ - h_);

  const auto rewind_to = [&](const Contact& impact) {
    w.x_event += impact.toi * (w.x_end - w.x_event);
    rest = rest_of(rest, impact.toi);
    const double advanced = impact.toi * (1 - toi);
    w.impulse_weighted += advanced * w.impulse;
    toi += advanced;
    start = impact.triangle;
    ++frame.events;
  };
  const auto ignore_around = [&](int triangle) {  // the solver holds these as constraints: no collision pairs
    for (int v : m.surface.facets.triangles[triangle])
      for (int t : m.surface.facets.topology.triangles_of(v)) w.ignored[t] = 1;
  };

  // Without contact: free motion up to the first impact, if there is one.
  if (start < 0) {
    m.surface.follow(w.u_free, w.u);
    w.x_end = w.x + h_ * w.u;
    Contact impact;
    if (!find_impact(impact)) return accept_free_motion();
    rewind_to(impact);
    frame.toi = toi;
    w.du.setZero();
  }

  // With contact: hold it for the rest of the step; what else is hit on the way ends the hold early.
  for (;;) {
    const double h_left = (1 - toi) * h_;
    if (1 - toi < kShortest) {
      contacts_.count = 0;
      w.x_end = w.x_event;
      break;
    }
    if (start >= 0) ignore_around(start);
    resolve_contacts(h_left, start);
    for (const Contact& contact : contacts_) ignore_around(contact.triangle);
    Contact impact;
    tool_.move(rest);
    const bool is_hit = find_impact(impact);
    tool_.move(sweep);  // the contact solver asks for the speed of the whole tick
    if (!is_hit) break;
    if (frame.events == kMaxEvents) {
      flags_ |= kEventsExhausted;
      break;
    }
    rewind_to(impact);
  }

  // q+ = q + h v_free + sum of what each impulse moved, and the velocity that goes with it.
  w.impulse_weighted += (1 - toi) * w.impulse;
  LocalState& s = m.state;
  const MatrixX &Y = m.dynamics->metric().Y, &Y_end = m.dynamics->end_response();
  s.q.noalias() += h_ * w.v_free;
  s.q_rate = w.v_free_end;
  for (int i = 0; i < m.model.patch.num_vertices(); ++i) {
    if (!node(w.impulse_weighted, i).isZero(0))
      s.q.noalias() += h_ * (Y.middleCols<3>(3 * i) * node(w.impulse_weighted, i));
    if (!node(w.impulse, i).isZero(0)) s.q_rate.noalias() += Y_end.middleCols<3>(3 * i) * node(w.impulse, i);
  }

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
  frame.force.setZero();
  for (int i = 0; i < kept; ++i) frame.force -= s.impulse[i] / h_;
  report_contacts(frame);
}

void LocalSimulation::find_contacts(const VectorX& x, int start) noexcept {
  const SurfacePatch& patch = model_->surface.facets;
  const ToolShape& shape = tool_.shape();
  const Vec3& tool = tool_.sweep().x_t1;
  if (shape.kind == ToolShape::Kind::point) {
    find_point_contacts(patch, x, tool, start, contacts_);
    return;
  }
  // Contacts that are not needed end with a zero impulse, so the margin only has to be wide enough for one tick.
  const double margin = 0.05 * shape.radius;
  LocalWorkspace& w = model_->work;
  const ToolSweep box = tool_.is_round() ? ToolSweep{tool, tool} : ToolSweep{tool_.box().low, tool_.box().high};
  const int found = model_->index->candidates(box, shape.radius + margin, w.candidates);
  find_tool_contacts(patch, x, tool_.core(), shape.radius, margin,
                     {w.candidates.data(), static_cast<std::size_t>(found)}, start, contacts_);
}

/// Finds contacts where the surface will be, solves them, moves the surface accordingly, until both agree.
/// A light triangle tilts under the tool and moves the contact point across it, so the plain iteration can swing
/// between two answers for ever: Aitken's relaxation (Irons and Tuck 1969) takes the part of the way that the last two
/// steps suggest. What is left of the gaps then is closed by close_gaps.
void LocalSimulation::resolve_contacts(double h_left, int start) noexcept {
  PreparedLocalModel& m = *model_;
  LocalWorkspace& w = m.work;
  ContactSet before = m.state.anchors;
  double relaxed = 1;
  for (int iteration = 0; iteration < kGeometryIterations; ++iteration) {
    place_surface(h_left, w.x_guess);
    if (tool_.shape().kind != ToolShape::Kind::point && iteration == 0) m.index->refit(w.x_event, w.x_guess);
    find_contacts(w.x_guess, start);
    if (!fill_problem(h_left)) flags_ |= kRigidContact;
    warm_start(before);
    solver_->solve(problem_, solution_);
    before = contacts_;
    for (int i = 0; i < contacts_.count; ++i) m.state.impulse[i] = solution_.impulse.segment<3>(3 * i);
    if (tool_.shape().kind == ToolShape::Kind::point) start = contacts_.contacts[0].triangle;

    w.du_guess = w.du;
    spread_impulses();
    place_surface(h_left, w.x_end);
    w.step_before.swap(w.step);
    w.step = w.du - w.du_guess;
    const bool is_settled = h_left * w.step.lpNorm<Eigen::Infinity>() < kSettled;
    if (is_settled && close_gaps(h_left, start)) return;
    if (is_settled) {
      relaxed = 1;
    } else if (iteration > 0) {
      const double turn = (w.step - w.step_before).squaredNorm();
      const double suggested = turn > 0 ? -relaxed * w.step_before.dot(w.step - w.step_before) / turn : 1.0;
      relaxed = std::clamp(suggested, kLeastRelaxed, kMostRelaxed);
    }
    if (iteration + 1 < kGeometryIterations) w.du = w.du_guess + relaxed * w.step;
  }
  close_gaps(h_left, start);
}

/// Where the surface is after a rest of the step with the motion that is known so far.
void LocalSimulation::place_surface(double h_left, VectorX& out) noexcept {
  LocalWorkspace& w = model_->work;
  w.motion = w.u_free + w.du;
  model_->surface.follow(w.motion, w.u);
  out = w.x_event + h_left * w.u;
}

/// False when a contact had to be softened because nothing there can move.
bool LocalSimulation::fill_problem(double h_left) noexcept {
  const PreparedLocalModel& m = *model_;
  const LocalWorkspace& w = m.work;
  const MatrixX& C = m.dynamics->metric().C;
  const int c = contacts_.count;
  problem_.count = c;
  problem_.sliding = m.state.sliding;
  problem_.h = h_;
  problem_.velocity.resize(3 * c);
  problem_.W.resize(3 * c, 3 * c);
  bool all_move = true;
  for (int i = 0; i < c; ++i) {
    const Contact& contact = contacts_.contacts[i];
    const auto motion = [&](const VectorX& patch) { return m.surface.at(patch, contact.triangle, contact.bary); };
    const Vec3& n = contact.normal;
    problem_.normal[i] = n;
    problem_.triangle[i] = m.surface.facets.global_triangle[contact.triangle];
    // The gap there would be without contact impulses, to first order.
    const double gap_free = contact.gap + allowed_overlap() + h_left * n.dot(motion(w.du));
    const Vec3 place = place_of(contact, w.x_guess);
    const Vec3 relative = motion(w.u_free) - tool_.way(place) / h_;
    problem_.velocity.segment<3>(3 * i) = relative - n.dot(relative) * n - gap_free / h_left * n;
    for (int k = 0; k <= i; ++k) {
      const Contact& other = contacts_.contacts[k];
      const Mat3 W = m.surface.couple(C, contact.triangle, contact.bary, other.triangle, other.bary);
      problem_.W.block<3, 3>(3 * i, 3 * k) = W;
      problem_.W.block<3, 3>(3 * k, 3 * i) = W.transpose();
    }
    auto own = problem_.W.block<3, 3>(3 * i, 3 * i);
    const double softest = h_ / (h_left * kHeaviest);
    if (own.trace() < 3 * softest) {
      own += softest * Mat3::Identity();
      all_move = false;
    }
  }
  return all_move;
}

/// Starts the solver from the impulses that the same triangles carried before.
void LocalSimulation::warm_start(const ContactSet& before) noexcept {
  solution_.impulse.setZero(3 * contacts_.count);
  for (int i = 0; i < contacts_.count; ++i)
    for (int k = 0; k < before.count; ++k)
      if (before.contacts[k].triangle == contacts_.contacts[i].triangle)
        solution_.impulse.segment<3>(3 * i) = model_->state.impulse[k];
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
