#include "collision/held/chosen_places.hpp"

#include <array>
#include <cstdint>
#include <utility>

namespace kt {
namespace {

constexpr int kMostPlaces = 1024;  // beyond them others say enough

/// The same for a triangle from tick to tick and from model to model, and without order over the surface.
std::uint32_t rank_of(const SurfacePatch& patch, int triangle) noexcept {
  const auto& global = patch.global_triangle;  // none: the whole surface
  auto h = static_cast<std::uint32_t>(global.empty() ? triangle : global[triangle]) + 0x9e3779b9u;
  for (int i = 0; i < 2; ++i) h = (h ^ (h >> 16)) * 0x45d9f3bu;
  return h ^ (h >> 16);
}

}  // namespace

void choose_apart(const SurfacePatch& patch, const VectorX& x, double radius, std::span<const int> candidates,
                  const std::function<std::optional<Contact>(int)>& contact_at, ContactSet& out) noexcept {
  constexpr int kRoom = kMaxContacts - 8;   // others come by: keep_pushing()
  constexpr double kWider = 1.18920711500;  // from try to try: a quarter of an octave
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
  double apart = 0.5 * (node(x, v[1]) - node(x, v[0])).norm();
  for (int attempt = 0; attempt < 64; ++attempt, apart *= kWider) {
    out.count = 0;
    bool has_room = true;
    for (const Contact& c : all) {
      const bool is_near = std::any_of(out.begin(), out.end(), [&](const Contact& kept) {
        return (c.core - kept.core - radius * (c.normal - kept.normal)).squaredNorm() < apart * apart;
      });
      if (is_near) continue;
      has_room = out.count < kRoom;
      if (!has_room) break;
      out.contacts[out.count] = c;
      out.contacts[out.count++].toi = kChosenMark;
    }
    if (has_room) return;
  }
}

}  // namespace kt
