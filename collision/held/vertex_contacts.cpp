#include "collision/held/vertex_contacts.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "collision/held/chosen_places.hpp"

namespace kt {
namespace {

Vec3 nearest_on(const ToolCore& core, const Vec3& at) noexcept {
  const Vec3& from = core.corners[0];
  if (core.corners.size() < 2) return from;
  const Vec3 along = core.corners[1] - from;
  const double length_sq = along.squaredNorm();
  return length_sq > 0 ? Vec3(from + std::clamp((at - from).dot(along) / length_sq, 0.0, 1.0) * along) : from;
}

/// Gives `take` the contact of each vertex that has one.
template <class Take>
void for_each_contact(const SurfacePatch& patch, const VectorX& x, const ToolCore& core, double radius, double margin,
                      std::span<const int> triangles, std::span<const char> is_place, std::vector<char>& is_seen,
                      const Take& take) noexcept {
  for (const int t : triangles)
    for (const int v : patch.triangles[t]) {
      if (std::exchange(is_seen[static_cast<std::size_t>(v)], 1)) continue;
      if (!is_place.empty() && !is_place[static_cast<std::size_t>(v)]) continue;
      const Vec3 at = node(x, v), place = nearest_on(core, at), apart = place - at;
      const double distance = apart.norm();
      if (!(distance < radius + margin && distance > 0)) continue;
      Contact contact;
      contact.triangle = patch.topology.triangles_of(v).front();  // the same one from tick to tick
      contact.bary = Vec3::Unit(std::ranges::find(patch.triangles[contact.triangle], v) -
                                patch.triangles[contact.triangle].begin());
      contact.normal = apart / distance;
      contact.gap = distance - radius;
      contact.core = place;
      take(contact);
    }
  for (const int t : triangles)
    for (const int v : patch.triangles[t]) is_seen[static_cast<std::size_t>(v)] = 0;
}

/// Sorts by how near they were.
/// @return  how many touched, or `room` if that is more
int keep_nearest(const SurfacePatch& patch, const VectorX& x_before, const ToolCore& core, double radius, int room,
                 std::span<Contact> found) noexcept {
  constexpr double kTouches = 1e-6;  // [m]
  const auto gap_before = [&](const Contact& c) {
    const Vec3 at = node(x_before, vertex_of(patch, c));
    return (at - nearest_on(core, at)).norm() - radius;
  };
  const auto is_nearer = [&](const Contact& a, const Contact& b) {
    return std::pair(gap_before(a), vertex_of(patch, a)) < std::pair(gap_before(b), vertex_of(patch, b));
  };
  std::ranges::sort(found, is_nearer);
  const auto touching = std::ranges::find_if(found, [&](const Contact& c) { return gap_before(c) > kTouches; });
  return std::max(room, static_cast<int>(touching - found.begin()));
}

/// Sorts by how far they are from their middle: where the pressure is highest first.
void sort_outwards(const SurfacePatch& patch, const VectorX& x, std::span<Contact> found) noexcept {
  Vec3 middle = Vec3::Zero();
  for (const Contact& c : found) middle += node(x, vertex_of(patch, c)) / static_cast<double>(found.size());
  const auto key = [&](const Contact& c) {
    const int v = vertex_of(patch, c);
    return std::pair((node(x, v) - middle).squaredNorm(), v);
  };
  std::ranges::sort(found, [&](const Contact& a, const Contact& b) { return key(a) < key(b); });
}

}  // namespace

void add_vertex_contacts(const SurfacePatch& patch, const VectorX& x, const VectorX& x_before, const ToolCore& core,
                         double radius, double margin, std::span<const int> triangles, std::span<const char> is_place,
                         int room, std::vector<char>& is_seen, ChosenVertices& chosen, ContactSet& out) noexcept {
  constexpr int kMost = 512;        // beyond them others say enough
  constexpr double kFewMore = 1.5;  // of a contact that has grown a little: its rim carries least
  const int first = out.count;
  int count = 0;
  for_each_contact(patch, x, core, radius, margin, triangles, is_place, is_seen, [&](const Contact& contact) {
    if (chosen.is_made && chosen.is_left_out[static_cast<std::size_t>(vertex_of(patch, contact))]) return;
    if (++count <= room) out.add(contact);
  });
  if (count <= room || chosen.is_made) return;
  out.count = first;
  count = 0;
  std::array<Contact, kMost> found;
  for_each_contact(patch, x, core, radius, margin, triangles, is_place, is_seen, [&](const Contact& contact) {
    if (count < kMost) found[static_cast<std::size_t>(count++)] = contact;
  });
  const std::span<Contact> all(found.data(), static_cast<std::size_t>(count));
  const int near = keep_nearest(patch, x_before, core, radius, room, all);
  chosen.is_made = true;
  std::ranges::fill(chosen.is_left_out, 0);
  for (const Contact& c : all) chosen.is_left_out[static_cast<std::size_t>(vertex_of(patch, c))] = 1;
  if (near > room) sort_outwards(patch, x_before, all.first(static_cast<std::size_t>(near)));
  if (near > kFewMore * room)
    choose_vertices_apart(patch, x, radius, all.first(static_cast<std::size_t>(near)), room, out);
  else
    for (const Contact& c : all.first(static_cast<std::size_t>(room))) out.add(c);
  for (int i = first; i < out.count; ++i)
    chosen.is_left_out[static_cast<std::size_t>(vertex_of(patch, out.contacts[i]))] = 0;
}

}  // namespace kt
