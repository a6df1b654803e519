#include "collision/held/chosen_places.hpp"

#include <array>
#include <utility>

namespace kt {
namespace {

constexpr int kMostPlaces = 1024;  // beyond them others say enough

/// The same for a triangle from tick to tick and from model to model, and without order over the surface.
std::uint32_t rank_of(const SurfacePatch& patch, int triangle) noexcept {
  const auto& global = patch.global_triangle;  // none: the whole surface
  return mixed(global.empty() ? triangle : global[triangle]);
}

/// Adds those of `all`, in their order, that lie apart from those before them, at a distance for which there is room.
/// @param apart  to begin with [m]      @param mark  Contact::toi of those added
void keep_apart(std::span<const Contact> all, double apart, double radius, int room, double mark,
                ContactSet& out) noexcept {
  constexpr double kWider = 1.18920711500;  // from try to try: a quarter of an octave
  const int first = out.count;
  for (int attempt = 0; attempt < 64; ++attempt, apart *= kWider) {
    out.count = first;
    bool has_room = true;
    for (const Contact& c : all) {
      const bool is_near = std::any_of(out.begin() + first, out.end(), [&](const Contact& kept) {
        return (c.core - kept.core - radius * (c.normal - kept.normal)).squaredNorm() < apart * apart;
      });
      if (is_near) continue;
      has_room = out.count < first + room;
      if (!has_room) break;
      out.contacts[out.count] = c;
      out.contacts[out.count++].toi = mark;
    }
    if (has_room) return;
  }
}

}  // namespace

int vertex_of(const SurfacePatch& patch, const Contact& contact) noexcept {
  Eigen::Index corner = 0;
  contact.bary.maxCoeff(&corner);
  return patch.triangles[contact.triangle][static_cast<std::size_t>(corner)];
}

void choose_apart(const SurfacePatch& patch, const VectorX& x, double radius, std::span<const int> candidates,
                  const std::function<std::optional<Contact>(int)>& contact_at, ContactSet& out) noexcept {
  constexpr int kRoom = kMaxContacts - 8;  // others come by: keep_pushing()
  std::array<Contact, kMostPlaces> found;
  int count = 0;
  for (const int t : candidates)
    if (count < kMostPlaces)
      if (const auto contact = contact_at(t)) found[static_cast<std::size_t>(count++)] = *contact;
  const auto all = std::span(found.data(), static_cast<std::size_t>(count));
  std::sort(all.begin(), all.end(), [&](const Contact& a, const Contact& b) {
    return std::pair(rank_of(patch, a.triangle), a.triangle) < std::pair(rank_of(patch, b.triangle), b.triangle);
  });
  const Triangle& v = patch.triangles[all[0].triangle];
  out.count = 0;
  keep_apart(all, 0.5 * (node(x, v[1]) - node(x, v[0])).norm(), radius, kRoom, kChosenMark, out);
}

void choose_vertices_apart(const SurfacePatch& patch, const VectorX& x, double radius, std::span<Contact> found,
                           int room, ContactSet& out) noexcept {
  std::sort(found.begin(), found.end(), [&](const Contact& a, const Contact& b) {
    return std::pair(mixed(vertex_of(patch, a)), a.triangle) < std::pair(mixed(vertex_of(patch, b)), b.triangle);
  });
  const Triangle& v = patch.triangles[found[0].triangle];
  keep_apart(found, 0.5 * (node(x, v[1]) - node(x, v[0])).norm(), radius, room, 0, out);
}

}  // namespace kt
