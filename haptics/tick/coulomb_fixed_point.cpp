// Contacts are found where the surface will be, solved, and move the surface accordingly, until both agree.
// A light triangle tilts under the tool and moves the contact point across it, so the plain iteration can swing
// between two answers for ever: Aitken's relaxation (Irons and Tuck 1969) takes the part of the way that the last two
// steps suggest. Where that is not enough, as for a ball in a crevice, both places hold the tool (keep_pushing). What
// is left of the gaps then is closed by close_gaps.
#include <algorithm>

#include "core/body/node_weights.hpp"
#include "haptics/contact/contact_sweeps.hpp"
#include "haptics/tick/coulomb_stages.hpp"
#include "haptics/tick/tick_stages.hpp"

namespace kt {
namespace {

constexpr int kGeometryIterations = 20;
constexpr int kOnRefinedCells = 8;      // of them: places are nodes, which stay where they are; two or three as a rule
constexpr double kSettled = 5e-7;       // [m] patch vertices at the guess and at the result agree: done
constexpr long kPlaces = 10'000;        // multiply-adds to look for the places of an iteration
constexpr int kExchanged = 5;           // iterations after which places that pushed are kept
constexpr double kLeastRelaxed = 0.15;  // of the way from the guess to the result
constexpr double kMostRelaxed = 4;      // a point on a sharp edge: blended and face normal differ, plain steps creep

/// What a fine patch yields by beside: R in the place of the patch's response.
void add_yield(PreparedLocalModel& m, const ContactSet& contacts, ContactMatrix& W) noexcept {
  if (!m.surface.fine) return;
  const int first = m.surface.num_nodes, c = contacts.count;
  std::array<NodeWeights, kMaxContacts> yields;
  for (int i = 0; i < c; ++i) {
    const NodeWeights moves = m.surface.moved_by(contacts.contacts[i].triangle, contacts.contacts[i].bary);
    for (int k = 0; k < moves.count; ++k)
      if (moves.node[k] >= first) yields[i].add(moves.node[k] - first, moves.weight[k]);
  }
  ContactMatrix& added = m.work.contact_coupling;
  added.resize(3 * c, 3 * c);
  couple_points(m.surface.fine->R, {yields.data(), static_cast<std::size_t>(c)}, m.work.coupling, added);
  W += m.yield_rate / m.dynamics->h() * added;
}

bool is_point(const TouchingTool& tool) noexcept { return tool.shape().kind == ToolShape::Kind::point; }

/// The same places of the surface, whose responses are the same.
bool are_same_places(const ContactSet& a, const ContactSet& b) noexcept {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Contact& one, const Contact& other) {
    return one.triangle == other.triangle && one.bary == other.bary;
  });
}

/// In problem.W, if they are not there.
void find_responses(TickState& tick) noexcept {
  PreparedLocalModel& m = *tick.model;
  if (tick.coupled_in == m.model.frame && are_same_places(tick.coupled, tick.contacts)) return;
  couple_contacts(m, tick.contacts, m.dynamics->metric().C, tick.problem.W);
  add_yield(m, tick.contacts, tick.problem.W);
  tick.work.take((m.surface.fine ? 18 : 9) * tick.problem.W.size());
  tick.coupled = tick.contacts;
  tick.coupled_in = m.model.frame;
}

/// How far the place of a contact has yielded with refined cells [m].
Vec3 yielded_at(const PreparedLocalModel& m, const Contact& c) noexcept {
  const NodeWeights moves = m.surface.moved_by(c.triangle, c.bary);
  Vec3 out = Vec3::Zero();
  for (int k = 0; k < moves.count; ++k)
    if (moves.node[k] >= m.surface.num_nodes)
      out += moves.weight[k] * node(m.state.yielded, moves.node[k] - m.surface.num_nodes);
  return out;
}

/// Of a scan. Refined cells yield linearly: a place in front of a tool that sticks to it would be drawn along without
/// end, past those ahead of it, where a body gets stiffer and lets it slip. It loses its hold with how much further it
/// has yielded the way that the tool goes along the surface than the tool's places have in the mean.
void find_lost_grip(TickState& tick) noexcept {
  constexpr double kBegins = 0.25, kAll = 0.5;  // of the contact's radius and way
  constexpr double kMost = 0.999;               // what has none is of another mode
  const PreparedLocalModel& m = *tick.model;
  const ContactSet& contacts = tick.contacts;
  tick.problem.lost_grip.fill(0);
  if (!m.surface.fine || !m.surface.is_embedded || !(m.surface.fine->width > 0)) return;
  for (int tool = 0; tool < tick.num_tools(); ++tool) {
    const auto is_its = [&](const Contact& c) { return c.tool == tool && m.surface.is_refined(c.triangle); };
    const ToolSweep& sweep = tick.tools[tool].whole.sweep();
    Vec3 mean = Vec3::Zero(), normal = Vec3::Zero();
    int count = 0;
    for (const Contact& c : contacts) {
      if (!is_its(c)) continue;
      mean += yielded_at(m, c);
      normal += c.normal;
      ++count;
    }
    if (count < 2 || normal.isZero(0)) continue;
    mean /= count;
    normal.normalize();
    const Vec3 way = sweep.x_t1 - sweep.x_t0, along = way - way.dot(normal) * normal;
    if (along.isZero(0)) continue;
    for (int i = 0; i < contacts.count; ++i) {
      const Contact& c = contacts.contacts[i];
      if (!is_its(c)) continue;
      const double further = (yielded_at(m, c) - mean).dot(along.normalized()) / m.surface.fine->width;
      tick.problem.lost_grip[i] = std::clamp((further - kBegins) / (kAll - kBegins), 0.0, kMost);
    }
  }
}

/// A contact is softened where nothing can move, and flagged, and where it has next to nothing of the tick left.
void fill_problem(TickState& tick) noexcept {
  PreparedLocalModel& m = *tick.model;
  const LocalWorkspace& w = m.work;
  ContactProblem& problem = tick.problem;
  const int c = tick.contacts.count;
  const double h_left = tick.h_left(), clamped = softest_contact(m), softest = clamped * tick.h / h_left;
  problem.count = c;
  problem.h = tick.h;
  problem.velocity.resize(3 * c);
  find_responses(tick);
  find_lost_grip(tick);
  for (int i = 0; i < c; ++i) {
    const Contact& contact = tick.contacts.contacts[i];
    TouchingTool& tool = tick.tools[contact.tool];
    const auto motion = [&](const VectorX& patch) { return m.surface.at(patch, contact.triangle, contact.bary); };
    const Vec3& n = contact.normal;
    problem.normal[i] = n;
    problem.sliding[i] = m.state.sliding[contact.tool];
    problem.triangle[i] = m.surface.facets.global_triangle[contact.triangle];
    // The gap there would be without contact impulses, to first order.
    const double gap_free = contact.gap + m.state.overlap[contact.tool].allowed() + h_left * n.dot(motion(w.du));
    const Vec3 place = place_of(tick, contact, w.x_guess);
    const Vec3 relative = motion(w.u_free) - tool.whole.way(place) / tick.h;
    problem.velocity.segment<3>(3 * i) = relative - n.dot(relative) * n - gap_free / h_left * n;
    auto own = problem.W.block<3, 3>(3 * i, 3 * i);
    if (own.trace() < 3 * softest) {
      if (own.trace() < 3 * clamped) tool.flags |= kRigidContact;
      own += softest * Mat3::Identity();
      tick.coupled_in = -1;  // not the body's own
    }
  }
}

/// The solution is as good as the law is asked for; that of the first guess need not be.
bool is_solved(const TickState& tick) noexcept {
  return !tick.problem.is_first || tick.solution.residual <= SweepLimits().residual;
}

/// Contacts of the surface at x_guess, and the impulses that the law gives them.
/// @param pushing  that the last solution, or the last tick, pushed at; then those of this one
/// @param before   contacts of the last iteration, or of the last tick; then those of this one
/// @param iteration  0: nothing has been solved yet
void solve_at_guess(TickState& tick, ContactSet& pushing, ContactSet& before, int iteration) noexcept {
  LocalState& s = tick.model->state;
  ContactSet& contacts = tick.contacts;
  find_contacts(tick, tick.model->work.x_guess, contacts);
  if (contacts.count == kMaxContacts) tick.add_flag(kContactsExhausted);
  drop_clear_places(tick, pushing, contacts);
  if (iteration >= kExchanged) keep_pushing(tick, before, contacts);
  fill_problem(tick);
  tick.problem.is_bounded = tick.model->surface.fine != nullptr;
  tick.problem.is_first = tick.problem.is_bounded && iteration == 0;
  tick.problem.is_repeated = iteration > 3;
  tick.problem.work = &tick.work;
  tick.work.take(kPlaces);
  warm_start(tick, before, tick.solution.impulse);
  tick.solver->solve(tick.problem, tick.solution);
  before = contacts;
  pushing.count = 0;
  for (int i = 0; i < contacts.count; ++i) {
    s.impulse[i] = tick.solution.impulse.segment<3>(3 * i);
    if (tick.solution.mode[i] != ContactMode::free) pushing.add(contacts.contacts[i]);
  }
  for (int i = contacts.count - 1; i >= 0; --i)  // the first of each point tool
    if (TouchingTool& tool = tick.tools[contacts.contacts[i].tool]; is_point(tool))
      tool.start = contacts.contacts[i].triangle;
}

/// Aitken's share of the way from the guess to the result.
/// @param last  share that led to this guess
double relax(const VectorX& step_before, const VectorX& step, double last) noexcept {
  const double turn = (step - step_before).squaredNorm();
  const double suggested = turn > 0 ? -last * step_before.dot(step - step_before) / turn : 1.0;
  return std::clamp(suggested, kLeastRelaxed, kMostRelaxed);
}

}  // namespace

void resolve_contacts(TickState& tick) noexcept {
  LocalWorkspace& w = tick.model->work;
  ContactSet before = tick.model->state.anchors, pushing = before;
  for (int k = 0; k < tick.num_tools(); ++k) {
    w.num_near[k] = -1;
    w.near_is_ignored[k] = false;
    w.near[k].is_known = false;
    w.chosen[k].is_made = false;
  }
  place_surface(tick, w.x_guess);
  if (std::ranges::any_of(tick.tools, [](const TouchingTool& tool) { return tool.start >= 0 && !is_point(tool); }))
    tick.index().refit(w.x_event, w.x_guess);
  const int most = tick.model->surface.fine ? kOnRefinedCells : kGeometryIterations;
  double relaxed = 1, largest = 0;
  for (int iteration = 0;; ++iteration) {
    solve_at_guess(tick, pushing, before, iteration);
    if (is_solved(tick)) largest = std::max(largest, tick.solution.residual);
    w.du_guess = w.du;
    spread_impulses(tick);
    place_surface(tick, w.x_end);
    w.step_before.swap(w.step);
    w.step = w.du - w.du_guess;
    const bool is_settled = is_solved(tick) && tick.h_left() * w.step.lpNorm<Eigen::Infinity>() < kSettled;
    if (is_settled && close_gaps(tick)) {  // what the solutions before the last one left is gone
      tick.residual = std::max(tick.residual, tick.solution.residual);
      return;
    }
    if (is_settled)
      relaxed = 1;
    else if (iteration > 0)
      relaxed = relax(w.step_before, w.step, relaxed);
    if (tick.work.is_over()) {
      tick.add_flag(kWorkExhausted);
      largest = std::max(largest, tick.solution.residual);  // of a first guess, too: nothing better comes
      break;
    }
    if (iteration + 1 == most) break;
    w.du = w.du_guess + relaxed * w.step;
    if (is_settled)
      place_surface(tick, w.x_guess);  // close_gaps has moved the surface's end
    else
      w.x_guess += relaxed * (w.x_end - w.x_guess);  // it is linear in du
  }
  close_gaps(tick);
  tick.residual = std::max(tick.residual, largest);
}

void place_surface(const TickState& tick, VectorX& out) noexcept {
  LocalWorkspace& w = tick.model->work;
  w.motion = w.u_free + w.du;
  follow(tick, w.motion, w.u);
  out = w.x_event + tick.h_left() * w.u;
}

void couple_contacts(PreparedLocalModel& model, const ContactSet& contacts, const MatrixX& C,
                     ContactMatrix& out) noexcept {
  const int c = contacts.count;
  std::array<NodeWeights, kMaxContacts> moves;
  for (int i = 0; i < c; ++i) {
    moves[i] = model.surface.moved_by(contacts.contacts[i].triangle, contacts.contacts[i].bary);
    while (moves[i].count > 0 && moves[i].node[moves[i].count - 1] >= model.surface.num_nodes)
      --moves[i].count;  // ascending: yielding points come last
  }
  out.resize(3 * c, 3 * c);
  couple_points(C, {moves.data(), static_cast<std::size_t>(c)}, model.work.coupling, out);
}

void spread_impulses(TickState& tick) noexcept {
  PreparedLocalModel& m = *tick.model;
  LocalWorkspace& w = m.work;
  w.impulse.setZero();
  for (int i = 0; i < tick.contacts.count; ++i) {
    const Contact& contact = tick.contacts.contacts[i];
    m.surface.add_at(w.impulse, contact.triangle, contact.bary, tick.solution.impulse.segment<3>(3 * i));
  }
  w.du.setZero();
  const MatrixX& C = m.dynamics->metric().C;
  for (int i = 0; i < m.model.patch.num_vertices(); ++i)
    if (!node(w.impulse, i).isZero(0)) w.du.head(C.rows()).noalias() += C.middleCols<3>(3 * i) * node(w.impulse, i);
  m.add_yield(w.impulse, w.du);
}

}  // namespace kt
