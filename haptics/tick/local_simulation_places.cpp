// Which places of the surface a tick holds: those found where the surface is guessed to be, those that the last guess
// pushed at, without those that nothing needs.
#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/held/chosen_places.hpp"
#include "collision/held/tool_contacts.hpp"
#include "collision/shape/apart_on_tool.hpp"
#include "haptics/tick/local_simulation.hpp"

namespace kt {
namespace {

constexpr double kSamePlace = 0.001;  // of a triangle's first edge
constexpr double kLookWithin = 0.05;  // of the smaller of the tool's radius and a cell: contacts are looked for within

/// Side of a square of two such triangles [m]; infinite: none.
double cell_of(const SurfacePatch& patch, const VectorX& x, int triangle) noexcept {
  if (triangle < 0) return std::numeric_limits<double>::infinity();
  const Triangle& v = patch.triangles[triangle];
  const Vec3 a = node(x, v[0]);
  return std::sqrt((node(x, v[1]) - a).cross(node(x, v[2]) - a).norm());
}

/// By the tool, and by the surface without contact [m].
double moved_in_a_tick(const ToolSweep& sweep, double h, const VectorX& u_free) noexcept {
  return (sweep.x_t1 - sweep.x_t0).norm() + 2 * h * u_free.lpNorm<Eigen::Infinity>();
}

}  // namespace

/// Of the tools that touch; another one is found when it hits.
void LocalSimulation::find_contacts(const VectorX& x) noexcept {
  if (num_tools() == 1) return find_contacts_of(0, x, contacts_);
  contacts_.count = 0;
  for (int k = 0; k < num_tools(); ++k) {
    if (tools_[k].start < 0) continue;
    find_contacts_of(k, x, found_);
    for (Contact contact : found_) {
      contact.tool = k;
      contacts_.add(contact);
    }
  }
}

void LocalSimulation::find_contacts_of(int tool, const VectorX& x, ContactSet& out) noexcept {
  const SurfacePatch& patch = model_->surface.facets;
  const MovingTool& moving = tools_[tool].moving;
  const ToolShape& shape = moving.shape();
  const Vec3& place = moving.sweep().x_t1;
  const int start = tools_[tool].start;
  if (shape.kind == ToolShape::Kind::point) {
    find_point_contacts(patch, x, place, start, out);
    return;
  }
  // Contacts that are not needed end with a zero impulse, so the margin only has to be wide enough for one tick. Of a
  // tool that is large beside the surface's cells a share of its radius would be the whole surface.
  const double margin =
      std::min(kLookWithin * shape.radius,
               kLookWithin * cell_of(patch, x, start) + moved_in_a_tick(moving.sweep(), h_, model_->work.u_free));
  LocalWorkspace& w = model_->work;
  std::vector<int>& facets = w.near_facets[tool];
  int& count = w.num_near[tool];
  // Along the way that is left: a triangle that the tool pushes ahead of it is where the index has it, not where the
  // tool ends.
  const ToolSweep box =
      moving.is_round() ? ToolSweep{tools_[tool].rest.x_t0, place} : ToolSweep{moving.box().low, moving.box().high};
  if (count < 0) count = index().candidates(box, shape.radius + margin, facets);
  find_tool_contacts(patch, x, moving.core(), shape.radius, margin, {facets.data(), static_cast<std::size_t>(count)},
                     start, w.near[tool], out, place - tools_[tool].rest.x_t0, model_->state.overlap[tool].allowed());
  if (!are_chosen(out)) return;
  add_flag(kContactsExhausted);
  for (int i = 0; i < count; ++i) w.ignored[tool][facets[i]] = 1;  // what lies between may reach into the tool
}

/// Adds the places that the last iteration pushed at and that are not found any more: every place of the surface must
/// stay outside the tool, so both are held from then on (the exchange method for as many constraints as places:
/// Hettich and Kortanek 1993).
/// @param before  contacts of the last iteration, which solution_ is of
void LocalSimulation::keep_pushing(const ContactSet& before) noexcept {
  const LocalWorkspace& w = model_->work;
  const SurfacePatch& patch = model_->surface.facets;
  const auto place = [&](const Contact& c) {
    Vec3 out = Vec3::Zero();
    for (int k = 0; k < 3; ++k) out += c.bary[k] * node(w.x_guess, patch.triangles[c.triangle][k]);
    return out;
  };
  for (int i = 0; i < before.count && contacts_.count < kMaxContacts; ++i) {
    const Contact& pushed = before.contacts[i];
    const ToolShape& shape = tool_of(pushed).moving.shape();
    if (solution_.mode[i] == ContactMode::free || shape.kind == ToolShape::Kind::point) continue;
    const Triangle& v = patch.triangles[pushed.triangle];
    const double apart = kSamePlace * (node(w.x_guess, v[1]) - node(w.x_guess, v[0])).norm();
    const Vec3 at = place(pushed);
    if (std::ranges::any_of(contacts_, [&](const Contact& c) {
          return c.tool == pushed.tool && (place(c) - at).squaredNorm() <= apart * apart;
        }))
      continue;
    if (const auto kept = same_contact(patch, w.x_guess, pushed, shape.radius)) contacts_.add(*kept);
  }
}

/// Starts the solver from the impulses that the same triangles carried before; of a tool with edges, that the nearest
/// place of it did.
void LocalSimulation::warm_start(const ContactSet& before) noexcept {
  solution_.impulse.setZero(3 * contacts_.count);
  std::array<bool, kMaxContacts> is_taken{};
  for (int i = 0; i < contacts_.count; ++i) {
    const Contact& now = contacts_.contacts[i];
    const MovingTool& tool = tool_of(now).moving;
    const double radius = tool.shape().radius;
    const auto is_near = [&](const Contact& a, const Contact& b) {
      if (tool.is_round()) return a.triangle == b.triangle;
      const auto& triangles = model_->surface.facets.triangles;
      return std::ranges::find_first_of(triangles[a.triangle], triangles[b.triangle]) != triangles[a.triangle].end();
    };
    int nearest = -1;
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < before.count; ++k) {
      const Contact& c = before.contacts[k];
      if (is_taken[k] || c.tool != now.tool || !is_near(c, now)) continue;
      if (const double apart = apart_on_tool_sq(c, now, radius); apart < least) {
        least = apart;
        nearest = k;
      }
    }
    if (nearest < 0) continue;
    is_taken[nearest] = true;
    solution_.impulse.segment<3>(3 * i) = model_->state.impulse[nearest];
  }
}

/// Lets go of places of tools with edges that the solver need not hold, since its time grows with their number, and
/// most where two are nearly one: those that nothing has pushed at and that stay clear, and those close beside a deeper
/// one, which carries their force a little aside. What is reached after all is seen when gaps are closed, as that looks
/// at all of them.
/// @param before  that the last solution, or the last tick, pushed at
void LocalSimulation::drop_clear_places(const ContactSet& before) noexcept {
  constexpr double kClear = 1e-5;     // [m] at the guess, which is that close to the result
  constexpr double kBeside = 0.1;     // of a triangle's first edge
  constexpr double kSameWay = 0.995;  // cosine
  const SurfacePatch& patch = model_->surface.facets;
  std::array<int, kMaxContacts> order;
  int count = 0, kept = 0;
  std::array<bool, kMaxContacts> is_held{};
  for (int i = 0; i < contacts_.count; ++i) {
    const Contact& c = contacts_.contacts[i];
    const bool is_round = tool_of(c).moving.is_round();
    const auto is_it = [&](const Contact& b) { return b.triangle == c.triangle && b.tool == c.tool; };
    if (is_round || !std::isfinite(c.gap))  // what is no number cannot be sorted
      is_held[i] = true;
    else if (c.gap + model_->state.overlap[c.tool].allowed() < kClear ||
             std::any_of(before.begin(), before.end(), is_it))
      order[count++] = i;
  }
  std::sort(order.begin(), order.begin() + count,
            [&](int a, int b) { return contacts_.contacts[a].gap < contacts_.contacts[b].gap; });
  for (int k = 0; k < count; ++k) {
    const Contact& c = contacts_.contacts[order[k]];
    const Triangle& v = patch.triangles[c.triangle];
    const double beside_sq =
        kBeside * kBeside * (node(model_->work.x_guess, v[1]) - node(model_->work.x_guess, v[0])).squaredNorm();
    is_held[order[k]] = std::none_of(order.begin(), order.begin() + k, [&](int i) {
      const Contact& other = contacts_.contacts[i];
      const Triangle& o = patch.triangles[other.triangle];
      return is_held[i] && other.tool == c.tool && (other.core - c.core).squaredNorm() < beside_sq &&
             other.normal.dot(c.normal) > kSameWay && std::ranges::find_first_of(v, o) != v.end();
    });
  }
  for (int i = 0; i < contacts_.count; ++i)
    if (is_held[i]) contacts_.contacts[kept++] = contacts_.contacts[i];
  contacts_.count = kept;
}

}  // namespace kt
