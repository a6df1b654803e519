// A constraint on where the surface is at the end of a tick says nothing about how fast it is then. Stepped exactly, a
// free mass that a constant force brings to the tool's place ends with twice the speed that it lacked, and the next
// tick takes it back: the force would swing from tick to tick for ever. So contacts give a second impulse, at the end,
// that takes away the speed that is left: SHAKE and RATTLE (Andersen 1983).
#include <Eigen/LU>
#include <algorithm>

#include "core/body/node_weights.hpp"
#include "haptics/tick/coulomb_stages.hpp"
#include "haptics/tick/tick_stages.hpp"

namespace kt {
namespace {

/// One condition on the speed of a contact, and the impulse that is there to meet it.
struct SpeedCondition {
  int contact = 0;
  Vec3 along = Vec3::Zero();    // no speed along it
  Vec3 impulse = Vec3::Zero();  // on the body, of unknown size
};

constexpr int kMaxConditions = 3 * kMaxContacts;
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxConditions, kMaxConditions>;

/// Whether a contact is on refined cells that yield to an impulse by more than the body does. These have no mass, so
/// that their rate takes on the tool's speed by itself; an impulse that meets a condition would have to give that speed
/// to the coarse nodes: at a touch by 40 mm/s, half a gram or 20 mN for a tick.
bool has_soft_cells(const TickState& tick, const Contact& contact) noexcept {
  const PreparedLocalModel& m = *tick.model;
  if (!m.surface.is_refined(contact.triangle)) return false;
  const NodeWeights moves = m.surface.moved_by(contact.triangle, contact.bary);
  const auto body_end = std::find_if(moves.node.begin(), moves.node.begin() + moves.count,
                                     [&](int i) { return i >= m.surface.num_nodes; });
  const auto body = static_cast<int>(body_end - moves.node.begin());  // ascending: yielding points come last
  const auto along = [&](const MatrixX& response, int first, int from, int end) {
    double sum = 0;
    for (int a = from; a < end; ++a)
      for (int b = from; b < end; ++b)
        sum += moves.weight[a] * moves.weight[b] *
               contact.normal.dot(response.block<3, 3>(3 * (moves.node[a] - first), 3 * (moves.node[b] - first)) *
                                  contact.normal);
    return sum;
  };
  return m.yield_rate / m.dynamics->h() * along(m.surface.fine->R, m.surface.num_nodes, body, moves.count) >
         along(m.dynamics->kick().C, 0, 0, body);
}

/// No speed along the normal, nor along the surface where it sticks. None where a contact pulls, and of those on soft
/// cells.
/// @return  how many
int collect_conditions(const TickState& tick, std::array<SpeedCondition, kMaxConditions>& out) noexcept {
  int n = 0;
  for (int i = 0; i < tick.contacts.count; ++i) {
    const Vec3 &normal = tick.contacts.contacts[i].normal, &impulse = tick.model->state.impulse[i];
    const double push = -impulse.dot(normal);
    if (!(push > 0)) return 0;
    if (has_soft_cells(tick, tick.contacts.contacts[i])) continue;
    if (tick.solution.mode[i] == ContactMode::stick) {
      for (int k = 0; k < 3; ++k) out[n++] = {i, Vec3::Unit(k), Vec3::Unit(k)};
    } else {
      out[n++] = {i, normal, impulse / push};
    }
  }
  return n;
}

/// Sizes of the conditions' impulses with which all are met.
/// @param rate  velocities of the patch's vertices [m/s], (3p)      @param W  response of the contacts to kicks
ContactVector meet_conditions(const TickState& tick, std::span<const SpeedCondition> condition, const VectorX& rate,
                              const ContactMatrix& W) noexcept {
  const PreparedLocalModel& m = *tick.model;
  const auto n = static_cast<int>(condition.size());
  Matrix A(n, n);
  ContactVector wanted(n);
  for (int a = 0; a < n; ++a) {
    const Contact& c = tick.contacts.contacts[condition[a].contact];
    const Vec3 place = place_of(tick, c, m.work.x_end);
    const Vec3 speed = m.surface.at(rate, c.triangle, c.bary) - tick.tool_of(c).whole.way(place) / tick.h;
    wanted[a] = -speed.dot(condition[a].along);
    for (int b = 0; b < n; ++b)
      A(a, b) = condition[a].along.dot(W.block<3, 3>(3 * condition[a].contact, 3 * condition[b].contact) *
                                       condition[b].impulse);
  }
  return A.partialPivLu().solve(wanted);
}

/// Whether each contact pushes with this impulse, and one that sticks does so within its cone.
bool are_allowed(const TickState& tick, const std::array<Vec3, kMaxContacts>& impulse) noexcept {
  for (int i = 0; i < tick.contacts.count; ++i) {
    const Vec3& normal = tick.contacts.contacts[i].normal;
    const double push = -impulse[i].dot(normal);
    const bool slips = tick.solution.mode[i] == ContactMode::stick &&
                       (impulse[i] + push * normal).norm() > tick.solution.grip[i] * push;
    if (!(push > 0) || slips) return false;
  }
  return true;
}

}  // namespace

void settle_velocities(TickState& tick) noexcept {
  PreparedLocalModel& m = *tick.model;
  const Response& kick = m.dynamics->kick();
  if (kick.Y.size() == 0) return;
  LocalState& s = m.state;
  std::array<SpeedCondition, kMaxConditions> room;
  const int n = collect_conditions(tick, room);
  if (n == 0) return;
  const std::span<const SpeedCondition> condition(room.data(), static_cast<std::size_t>(n));
  VectorX& rate = m.work.u_free;  // what a fine patch yields by stays: it has no velocity of its own
  m.recover_patch(s.q_rate, rate);
  ContactMatrix& response = m.work.contact_coupling;
  couple_contacts(m, tick.contacts, kick.C, response);
  const ContactVector size = meet_conditions(tick, condition, rate, response);
  if (!size.allFinite()) return;

  std::array<Vec3, kMaxContacts> impulse = s.impulse;
  for (int a = 0; a < n; ++a) impulse[condition[a].contact] += size[a] * condition[a].impulse;
  if (!are_allowed(tick, impulse)) return;
  for (int i = 0; i < tick.contacts.count; ++i) {
    const Vec3 added = impulse[i] - s.impulse[i];
    const Contact& c = tick.contacts.contacts[i];
    const NodeWeights moves = m.surface.moved_by(c.triangle, c.bary);
    for (int k = 0; k < moves.count && moves.node[k] < m.surface.num_nodes; ++k)
      s.q_rate.noalias() += kick.Y.middleCols<3>(3 * moves.node[k]) * (moves.weight[k] * added);
    s.impulse[i] = impulse[i];
    tick.solution.impulse.segment<3>(3 * i) = impulse[i];
  }
}

}  // namespace kt
