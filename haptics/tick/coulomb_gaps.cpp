// Contacts are found where the surface was guessed to be, so the surface they are solved for is off by what the guess
// was off. Here that is made good: each contact's impulse is scaled until the tool lies on the surface to the last
// digits.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "collision/shape/apart_on_tool.hpp"
#include "haptics/tick/coulomb_stages.hpp"

namespace kt {
namespace {

constexpr double kClosed = 1e-12;  // [m] a tool that is not deeper than this is on the surface
constexpr double kOpen = 1e-6;     // [m] a contact that pushes is not further away than this
constexpr double kGetsOn = 0.5;    // of the largest gap is left after a correction, else another will not do either
constexpr int kCorrections = 4;    // Newton's method: each squares the gap, as long as the tool stays on its triangles

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxContacts, kMaxContacts>;
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxContacts, 1>;

/// The contact of `held` that went over into `now`: on the same triangle, else the next one that faces the same way;
/// -1.
int before(const SurfacePatch& patch, const ContactSet& held, const Contact& now) noexcept {
  constexpr double kSameWay = 0.9;  // cosine
  double best = kSameWay;
  std::pair nearest(std::numeric_limits<double>::infinity(), 0.0);
  int found = -1, next = -1;
  for (int i = 0; i < held.count; ++i) {  // of an extended tool, several may be on it
    const Contact& c = held.contacts[i];
    const std::pair apart((c.core - now.core).squaredNorm(), (c.bary - now.bary).squaredNorm());
    if (c.tool != now.tool || c.triangle != now.triangle || apart >= nearest) continue;
    nearest = apart;
    found = i;
  }
  for (int i = 0; i < held.count && found < 0; ++i) {
    const Contact& c = held.contacts[i];
    const double along = c.normal.dot(now.normal);
    const Triangle &a = patch.triangles[c.triangle], &b = patch.triangles[now.triangle];
    if (c.tool != now.tool || along <= best || std::ranges::find_first_of(a, b) == a.end()) continue;
    best = along;
    next = i;
  }
  return found < 0 ? next : found;
}

/// The same of a tool with edges: the one that touches at the nearest place of it, on a triangle nearby; -1.
int before_on_tool(const SurfacePatch& patch, const ContactSet& held, const Contact& now, double radius) noexcept {
  double nearest_sq = std::numeric_limits<double>::infinity();
  int found = -1;
  for (int i = 0; i < held.count; ++i) {
    const Contact& c = held.contacts[i];
    const double apart_sq = apart_on_tool_sq(c, now, radius);
    const Triangle &a = patch.triangles[c.triangle], &b = patch.triangles[now.triangle];
    if (c.tool != now.tool || apart_sq >= nearest_sq || std::ranges::find_first_of(a, b) == a.end()) continue;
    nearest_sq = apart_sq;
    found = i;
  }
  return found;
}

/// before() of each contact. Of several that would be the same one, those that are clear but for the nearest are none:
/// they are places that were not held, since they were clear.
/// @param gap  of each of `now` [m]      @param radius  of the tool that is no sphere; 0: it is one
template <class Radius>
std::array<int, kMaxContacts> pair_up(const SurfacePatch& patch, const ContactSet& held, const ContactSet& now,
                                      const std::array<double, kMaxContacts>& gap, const Radius& radius) noexcept {
  std::array<int, kMaxContacts> of, nearest;
  nearest.fill(-1);
  const auto apart = [&](int k, int i) {
    const Contact& c = now.contacts[k];
    if (const double r = radius(c); r > 0) return std::pair(false, apart_on_tool_sq(c, held.contacts[i], r));
    const bool on_another = now.contacts[k].triangle != held.contacts[i].triangle;
    return std::pair(on_another, (now.contacts[k].core - held.contacts[i].core).squaredNorm());
  };
  for (int k = 0; k < now.count; ++k) {
    const Contact& c = now.contacts[k];
    const double r = radius(c);
    const int i = of[k] = r > 0 ? before_on_tool(patch, held, c, r) : before(patch, held, c);
    if (i >= 0 && (nearest[i] < 0 || apart(k, i) < apart(nearest[i], i))) nearest[i] = k;
  }
  for (int k = 0; k < now.count; ++k)
    if (of[k] >= 0 && nearest[of[k]] != k && gap[k] >= -kClosed) of[k] = -1;
  return of;
}

/// Impulses >= 0 with gap + A (impulse - before) >= 0, and = 0 where they push: directly, over the set of those that
/// push, from which whoever would pull is let go and to which whoever is overlapped comes. Two contacts on both sides
/// of a blunt edge are nearly one, so that sweeps over them would hardly get on. False: no answer, as when two are one.
bool push_apart(const Matrix& A, Vector gap, Vector& impulse, ContactWork& work) noexcept {
  const auto n = static_cast<int>(gap.size());
  gap -= A * impulse;  // there would be without impulses
  std::array<int, kMaxContacts> pushing;
  int count = 0;
  for (int i = 0; i < n; ++i)  // those that come anew are added where they have to
    if (impulse[i] > 0) pushing[count++] = i;
  for (int change = 0; change <= 2 * n && !work.is_over(); ++change) {
    work.take_factor(count);
    work.take(2L * n * n);
    Matrix own(count, count);
    Vector wanted(count);
    for (int i = 0; i < count; ++i) {
      wanted[i] = -gap[pushing[i]];
      for (int k = 0; k < count; ++k) own(i, k) = A(pushing[i], pushing[k]);
    }
    const Vector found = own.partialPivLu().solve(wanted);
    if (!found.allFinite()) return false;
    int weakest = -1;
    for (int i = 0; i < count; ++i)
      if (found[i] < 0 && (weakest < 0 || found[i] < found[weakest])) weakest = i;
    if (weakest >= 0) {
      pushing[weakest] = pushing[--count];
      continue;
    }
    impulse.setZero();
    for (int i = 0; i < count; ++i) impulse[pushing[i]] = found[i];
    const Vector left = gap + A * impulse;
    int deepest = -1;
    for (int i = 0; i < n; ++i)
      if (left[i] < -kClosed && (deepest < 0 || left[i] < left[deepest])) deepest = i;
    if (deepest < 0) return true;
    if (std::find(pushing.begin(), pushing.begin() + count, deepest) != pushing.begin() + count) return false;
    pushing[count++] = deepest;
  }
  return false;
}

/// How the gap changes as the surface yields: towards a sphere's centre; for a point the face's, not the blended one,
/// unless the gap is the distance from a plane.
Vec3 gap_slope(const SurfacePatch& patch, const VectorX& x, const Contact& contact, double radius) noexcept {
  if (radius > 0 && !patch.is_curved) return contact.normal;
  const Triangle& t = patch.triangles[contact.triangle];
  Vec3 offset = contact.core;
  for (int c = 0; c < 3; ++c) offset -= contact.bary[c] * node(x, t[c]);
  const double distance = offset.norm();
  constexpr double kRoundoff = 1e-12;  // [m]
  if (radius > 0 && contact.gap > -radius) return offset / distance;
  if (std::abs(distance - std::abs(contact.gap)) > kRoundoff) return face_normal(patch, x, contact.triangle);
  return distance > 0 ? Vec3(offset / std::copysign(distance, contact.gap)) : contact.normal;
}

/// One equation for each contact that has an impulse or needs one.
struct GapEquations {
  int n = 0;
  std::array<int, kMaxContacts> contact;     ///< of the tick
  std::array<Vec3, kMaxContacts> slope;      ///< of the gap as the surface yields
  std::array<Vec3, kMaxContacts> direction;  ///< of the impulse
  std::array<double, kMaxContacts> gap;      ///< [m]

  double widest() const noexcept {
    double out = 0;
    for (int i = 0; i < n; ++i) out = std::max(out, std::abs(gap[i]));
    return out;
  }
};

/// Places of the surface as it is now, and how they belong to the contacts that are held.
struct PlacesNow {
  ContactSet places;
  std::array<double, kMaxContacts> gap;  ///< [m]
  std::array<int, kMaxContacts> of;      ///< contact that came to be this place, -1
};

void find_places_now(TickState& tick, PlacesNow& out) noexcept {
  const PreparedLocalModel& m = *tick.model;
  const auto long_radius = [&](const Contact& c) {
    const MovingTool& tool = tick.tool_of(c).whole;
    return tool.is_round() ? 0.0 : tool.shape().radius;
  };
  find_contacts(tick, m.work.x_end, out.places);
  for (int k = 0; k < out.places.count; ++k) {
    const Contact& c = out.places.contacts[k];
    out.gap[k] = c.gap + m.state.overlap[c.tool].allowed();
  }
  out.of = pair_up(m.surface.facets, tick.contacts, out.places, out.gap, long_radius);
}

/// No place is overlapped, and none is clear that a contact pushes at.
bool is_closed(const PlacesNow& now, const ContactSolution& solution) noexcept {
  for (int k = 0; k < now.places.count; ++k) {
    const bool is_open = now.gap[k] > kOpen && now.of[k] >= 0 && solution.mode[now.of[k]] != ContactMode::free;
    if (!(now.gap[k] >= -kClosed) || is_open) return false;
  }
  return true;
}

/// False: a place that no contact holds is overlapped.
bool make_equations(const TickState& tick, const PlacesNow& now, GapEquations& out) noexcept {
  const PreparedLocalModel& m = *tick.model;
  std::array<int, kMaxContacts> row;
  row.fill(-1);
  for (int k = 0; k < now.places.count; ++k) {
    const Contact& c = now.places.contacts[k];
    const int i = now.of[k];
    if (i < 0) {
      if (!(now.gap[k] >= -kClosed)) return false;  // so does what is no number
      continue;
    }
    const bool pushes = tick.solution.mode[i] != ContactMode::free;
    if (!pushes && now.gap[k] >= -kClosed) continue;
    if (row[i] >= 0 && out.gap[row[i]] <= now.gap[k]) continue;
    if (row[i] < 0) out.contact[row[i] = out.n++] = i;
    const Vec3 impulse = tick.solution.impulse.segment<3>(3 * i), into = -tick.contacts.contacts[i].normal;
    out.direction[row[i]] = pushes ? Vec3(impulse / impulse.dot(into)) : into;
    out.slope[row[i]] = gap_slope(m.surface.facets, m.work.x_end, c, tick.tool_of(c).shape().radius);
    out.gap[row[i]] = now.gap[k];
  }
  return true;
}

/// Scales the impulses to where the gaps are closed, to first order. False: there is no such answer.
bool correct_impulses(TickState& tick, const GapEquations& equations) noexcept {
  const int n = equations.n;
  const std::array<int, kMaxContacts>& contact = equations.contact;
  const std::array<Vec3, kMaxContacts>&direction = equations.direction, &slope = equations.slope;
  ContactSolution& solution = tick.solution;
  Matrix A(n, n);
  Vector along(n);
  for (int i = 0; i < n; ++i) {
    along[i] = -solution.impulse.segment<3>(3 * contact[i]).dot(tick.contacts.contacts[contact[i]].normal);
    for (int k = 0; k < n; ++k)
      A(i, k) =
          -tick.h_left() * slope[i].dot(tick.problem.W.block<3, 3>(3 * contact[i], 3 * contact[k]) * direction[k]);
  }
  if (!push_apart(A, Eigen::Map<const Vector>(equations.gap.data(), n), along, tick.work)) return false;
  for (int i = 0; i < n; ++i) {
    solution.impulse.segment<3>(3 * contact[i]) = tick.model->state.impulse[contact[i]] = along[i] * direction[i];
    ContactMode& mode = solution.mode[contact[i]];
    if (along[i] == 0)
      mode = ContactMode::free;
    else if (mode == ContactMode::free)
      mode = ContactMode::slide;
  }
  return true;
}

}  // namespace

bool close_gaps(TickState& tick) noexcept {
  double off_before = std::numeric_limits<double>::infinity();
  for (int correction = 0; correction <= kCorrections; ++correction) {
    PlacesNow now;
    find_places_now(tick, now);
    if (is_closed(now, tick.solution)) {
      for (int k = 0; k < now.places.count; ++k)
        if (now.of[k] >= 0) tick.contacts.contacts[now.of[k]].gap = now.places.contacts[k].gap;
      return true;
    }
    GapEquations equations;
    if (!make_equations(tick, now, equations)) return false;
    const double off = equations.widest();
    if (correction == kCorrections || !(off < kGetsOn * off_before)) return false;
    off_before = off;
    if (!correct_impulses(tick, equations)) return false;
    spread_impulses(tick);
    place_surface(tick, tick.model->work.x_end);
  }
  return true;
}

}  // namespace kt
