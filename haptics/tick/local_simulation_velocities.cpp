// A constraint on where the surface is at the end of a tick says nothing about how fast it is then. Stepped exactly, a
// free mass that a constant force brings to the tool's place ends with twice the speed that it lacked, and the next
// tick takes it back: the force would swing from tick to tick for ever. So contacts give a second impulse, at the end,
// that takes away the speed that is left: SHAKE and RATTLE (Andersen 1983).
#include <Eigen/LU>

#include "haptics/tick/local_simulation.hpp"

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

}  // namespace

/// Along the normal, and along the surface too where it sticks. Where it slides the impulse keeps its direction, and so
/// its place in the cone of friction. Left out where a contact would come to pull, or a sticking one to slide.
void LocalSimulation::settle_velocities() noexcept {
  PreparedLocalModel& m = *model_;
  const Response& kick = m.dynamics->kick();
  if (kick.Y.size() == 0 || contacts_.count == 0) return;
  LocalState& s = m.state;
  std::array<SpeedCondition, kMaxConditions> condition;
  int n = 0;
  for (int i = 0; i < contacts_.count; ++i) {
    const Vec3& normal = contacts_.contacts[i].normal;
    const double push = -s.impulse[i].dot(normal);
    if (!(push > 0)) return;
    if (solution_.mode[i] == ContactMode::stick) {
      for (int k = 0; k < 3; ++k) condition[n++] = {i, Vec3::Unit(k), Vec3::Unit(k)};
    } else {
      condition[n++] = {i, normal, s.impulse[i] / push};
    }
  }

  VectorX& rate = m.work.u_free;
  m.recover_patch(s.q_rate, rate);
  couple_contacts(kick.C, problem_.W);  // the problem is solved: its room is free
  Matrix A(n, n);
  ContactVector wanted(n);
  for (int a = 0; a < n; ++a) {
    const Contact& c = contacts_.contacts[condition[a].contact];
    const Vec3 place = place_of(c, m.work.x_end);
    const Vec3 speed = m.surface.at(rate, c.triangle, c.bary) - tool_of(c).moving.way(place) / h_;
    wanted[a] = -speed.dot(condition[a].along);
    for (int b = 0; b < n; ++b)
      A(a, b) = condition[a].along.dot(problem_.W.block<3, 3>(3 * condition[a].contact, 3 * condition[b].contact) *
                                       condition[b].impulse);
  }
  const ContactVector size = A.partialPivLu().solve(wanted);
  if (!size.allFinite()) return;

  std::array<Vec3, kMaxContacts> impulse;
  for (int i = 0; i < contacts_.count; ++i) impulse[i] = s.impulse[i];
  for (int a = 0; a < n; ++a) impulse[condition[a].contact] += size[a] * condition[a].impulse;
  for (int i = 0; i < contacts_.count; ++i) {
    const Vec3& normal = contacts_.contacts[i].normal;
    const double push = -impulse[i].dot(normal);
    const bool slips =
        solution_.mode[i] == ContactMode::stick && (impulse[i] + push * normal).norm() > solution_.grip[i] * push;
    if (!(push > 0) || slips) return;
  }
  for (int i = 0; i < contacts_.count; ++i) {
    const Vec3 added = impulse[i] - s.impulse[i];
    const Contact& c = contacts_.contacts[i];
    const NodeWeights moves = m.surface.moved_by(c.triangle, c.bary);
    for (int k = 0; k < moves.count; ++k)
      s.q_rate.noalias() += kick.Y.middleCols<3>(3 * moves.node[k]) * (moves.weight[k] * added);
    s.impulse[i] = impulse[i];
    solution_.impulse.segment<3>(3 * i) = impulse[i];
  }
}

}  // namespace kt
