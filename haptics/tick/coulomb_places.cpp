// Which places of the surface a tick holds: those found where the surface is guessed to be, those that the last guess
// pushed at, without those that nothing needs.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "collision/held/chosen_places.hpp"
#include "collision/held/tool_contacts.hpp"
#include "collision/held/vertex_contacts.hpp"
#include "collision/shape/apart_on_tool.hpp"
#include "haptics/tick/coulomb_stages.hpp"

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

/// Of one tool's vertices: its share of the contacts, less those that keep_pushing() may add.
int room_for_vertices(const TickState& tick, const ContactSet& found) noexcept {
  constexpr int kLeast = 4, kAdded = 4;
  return std::max(kLeast, kMaxContacts / tick.num_tools() - kAdded - found.count);
}

/// Lets go of a contact from within refined facets: "nothing is in front of the core" says so where no facet was looked
/// at, and on a rough scan what is nearest may face away. Vertices say more. Held at one place from both sides, a tool
/// got 3e8 N.
void drop_inside(const ContactSurface& surface, double radius, ContactSet& contacts) noexcept {
  constexpr double kOn = 1 - 1e-9;
  const auto is_inside = [&](const Contact& c) { return c.gap < -kOn * radius && surface.is_refined(c.triangle); };
  const auto begin = contacts.contacts.begin();
  contacts.count = static_cast<int>(std::remove_if(begin, begin + contacts.count, is_inside) - begin);
}

/// Those of one tool.
void find_contacts_of(TickState& tick, int tool, const VectorX& x, ContactSet& out) noexcept {
  PreparedLocalModel& m = *tick.model;
  const SurfacePatch& patch = m.surface.facets;
  const TouchingTool& t = tick.tools[tool];
  const ToolShape& shape = t.shape();
  const Vec3& place = t.whole.sweep().x_t1;
  if (shape.kind == ToolShape::Kind::point) return find_point_contacts(patch, x, place, t.start, out);
  // Contacts that are not needed end with a zero impulse, so the margin only has to be wide enough for one tick. Of a
  // tool that is large beside the surface's cells a share of its radius would be the whole surface.
  const double margin =
      std::min(kLookWithin * shape.radius,
               kLookWithin * cell_of(patch, x, t.start) + moved_in_a_tick(t.whole.sweep(), tick.h, m.work.u_free));
  LocalWorkspace& w = m.work;
  std::vector<int>& facets = w.near_facets[tool];
  int& count = w.num_near[tool];
  // Along the way that is left: a triangle that the tool pushes ahead of it is where the index has it, not where the
  // tool ends.
  const Vec3& from = t.rest.sweep().x_t0;
  const ToolSweep box = t.whole.is_round() ? ToolSweep{from, place} : ToolSweep{t.whole.box().low, t.whole.box().high};
  const auto is_plain = [&](int facet) { return !m.surface.is_refined(facet); };
  if (count < 0) {
    count = tick.index().candidates(box, shape.radius + margin, w.candidates);
    const std::span<const int> found(w.candidates.data(), static_cast<std::size_t>(count));
    const auto plain_end = std::ranges::copy_if(found, facets.begin(), is_plain).out;  // each part ascending
    std::ranges::copy_if(found, plain_end, std::not_fn(is_plain));
    w.x_near = x;
    w.near_within[tool] = margin;
  }
  const std::span<const int> all(facets.data(), static_cast<std::size_t>(count));
  const bool touches_vertices =
      m.surface.fine && has_vertex_contacts(t.whole.core()) && !(m.state.overlap[tool].left > 0);
  const std::span<const int> plain =
      touches_vertices ? all.first(static_cast<std::size_t>(std::ranges::partition_point(all, is_plain) - all.begin()))
                       : all;
  find_tool_contacts(patch, x, t.whole.core(), shape.radius, margin, plain, t.start, w.near[tool], out, place - from,
                     m.state.overlap[tool].allowed());
  if (touches_vertices) {
    const int plain_count = out.count;
    // How fast what yields goes back without contact says nothing: in contact it does not.
    const double near = std::min(
        margin, kLookWithin * cell_of(patch, x, t.start) + (t.whole.sweep().x_t1 - t.whole.sweep().x_t0).norm());
    add_vertex_contacts(patch, x, m.work.x_event, t.whole.core(), shape.radius, near, all.subspan(plain.size()),
                        m.surface.is_place, room_for_vertices(tick, out), w.near[tool].is_seen, w.chosen[tool], out);
    if (out.count > plain_count) drop_inside(m.surface, shape.radius, out);
    for (const int facet : all) w.ignored[tool][facet] = 1;  // what lies between nodes may reach into the tool
    w.near_is_ignored[tool] = true;
  }
  if (!are_chosen(out)) return;
  tick.add_flag(kContactsExhausted);
  for (const int facet : all) w.ignored[tool][facet] = 1;  // what lies between may reach into the tool
  w.near_is_ignored[tool] = true;
}

}  // namespace

void find_contacts(TickState& tick, const VectorX& x, ContactSet& out) noexcept {
  if (tick.num_tools() == 1) return find_contacts_of(tick, 0, x, out);
  out.count = 0;
  for (int k = 0; k < tick.num_tools(); ++k) {
    if (tick.tools[k].start < 0) continue;
    find_contacts_of(tick, k, x, tick.found);
    for (Contact contact : tick.found) {
      contact.tool = k;
      out.add(contact);
    }
  }
}

bool is_nothing_left_to_hit(const TickState& tick) noexcept {
  constexpr double kRoundoff = 1 - 1e-6;
  const LocalWorkspace& w = tick.model->work;
  double within = std::numeric_limits<double>::infinity();
  for (int k = 0; k < tick.num_tools(); ++k) {
    if (!w.near_is_ignored[k]) return false;
    const MovingTool &whole = tick.tools[k].whole, &rest = tick.tools[k].rest;
    double outside = 0;  // [m] of the box that they were looked for in: what is left of a turn is a shorter chord
    if (!whole.is_round())
      outside =
          std::max(0.0, (whole.box().low - rest.box().low).cwiseMax(rest.box().high - whole.box().high).maxCoeff());
    within = std::min(within, w.near_within[k] - outside);
  }
  return (w.x_end - w.x_near).lpNorm<Eigen::Infinity>() <= kRoundoff * within && w.x_end.allFinite();
}

void drop_clear_places(const TickState& tick, const ContactSet& before, ContactSet& contacts) noexcept {
  constexpr double kClear = 1e-5;     // [m] at the guess, which is that close to the result
  constexpr double kBeside = 0.1;     // of a triangle's first edge
  constexpr double kSameWay = 0.995;  // cosine
  const SurfacePatch& patch = tick.model->surface.facets;
  const VectorX& x = tick.model->work.x_guess;
  std::array<int, kMaxContacts> order;
  int count = 0, kept = 0;
  std::array<bool, kMaxContacts> is_held{};
  for (int i = 0; i < contacts.count; ++i) {
    const Contact& c = contacts.contacts[i];
    const bool is_round = tick.tool_of(c).whole.is_round();
    const auto is_it = [&](const Contact& b) { return b.triangle == c.triangle && b.tool == c.tool; };
    if (is_round || !std::isfinite(c.gap))  // what is no number cannot be sorted
      is_held[i] = true;
    else if (c.gap + tick.model->state.overlap[c.tool].allowed() < kClear ||
             std::any_of(before.begin(), before.end(), is_it))
      order[count++] = i;
  }
  std::sort(order.begin(), order.begin() + count,
            [&](int a, int b) { return contacts.contacts[a].gap < contacts.contacts[b].gap; });
  for (int k = 0; k < count; ++k) {
    const Contact& c = contacts.contacts[order[k]];
    const Triangle& v = patch.triangles[c.triangle];
    const double beside_sq = kBeside * kBeside * (node(x, v[1]) - node(x, v[0])).squaredNorm();
    is_held[order[k]] = std::none_of(order.begin(), order.begin() + k, [&](int i) {
      const Contact& other = contacts.contacts[i];
      const Triangle& o = patch.triangles[other.triangle];
      return is_held[i] && other.tool == c.tool && (other.core - c.core).squaredNorm() < beside_sq &&
             other.normal.dot(c.normal) > kSameWay && std::ranges::find_first_of(v, o) != v.end();
    });
  }
  for (int i = 0; i < contacts.count; ++i)
    if (is_held[i]) contacts.contacts[kept++] = contacts.contacts[i];
  contacts.count = kept;
}

void keep_pushing(const TickState& tick, const ContactSet& before, ContactSet& contacts) noexcept {
  const VectorX& x = tick.model->work.x_guess;
  const SurfacePatch& patch = tick.model->surface.facets;
  const auto place = [&](const Contact& c) {
    Vec3 out = Vec3::Zero();
    for (int k = 0; k < 3; ++k) out += c.bary[k] * node(x, patch.triangles[c.triangle][k]);
    return out;
  };
  for (int i = 0; i < before.count && contacts.count < kMaxContacts; ++i) {
    const Contact& pushed = before.contacts[i];
    const ToolShape& shape = tick.tool_of(pushed).shape();
    if (tick.solution.mode[i] == ContactMode::free || shape.kind == ToolShape::Kind::point) continue;
    const Triangle& v = patch.triangles[pushed.triangle];
    const double apart = kSamePlace * (node(x, v[1]) - node(x, v[0])).norm();
    const Vec3 at = place(pushed);
    if (std::ranges::any_of(contacts, [&](const Contact& c) {
          return c.tool == pushed.tool && (place(c) - at).squaredNorm() <= apart * apart;
        }))
      continue;
    if (const auto kept = same_contact(patch, x, pushed, shape.radius)) contacts.add(*kept);
  }
}

void warm_start(const TickState& tick, const ContactSet& before, ContactVector& impulse) noexcept {
  const auto& triangles = tick.model->surface.facets.triangles;
  impulse.setZero(3 * tick.contacts.count);
  std::array<bool, kMaxContacts> is_taken{};
  for (int i = 0; i < tick.contacts.count; ++i) {
    const Contact& now = tick.contacts.contacts[i];
    const MovingTool& tool = tick.tool_of(now).whole;
    const double radius = tool.shape().radius;
    const auto is_near = [&](const Contact& a, const Contact& b) {
      if (tool.is_round()) return a.triangle == b.triangle;
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
    impulse.segment<3>(3 * i) = tick.model->state.impulse[nearest];
  }
}

}  // namespace kt
