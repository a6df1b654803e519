#pragma once
// Held contacts that were chosen from more places than there is room for: between them the surface may reach into the
// tool. Contact::toi is of no use to a held contact otherwise, so it carries the mark.
#include <algorithm>
#include <functional>
#include <optional>
#include <span>

#include "collision/held/surface_contacts.hpp"

namespace kt {

inline constexpr double kChosenMark = 1;  ///< Contact::toi; of the other held contacts it is 0

/// Whether any of them stands for others beside it.
inline bool are_chosen(const ContactSet& contacts) noexcept {
  return std::any_of(contacts.begin(), contacts.end(), [](const Contact& c) { return c.toi == kChosenMark; });
}

/// More places than there is room for, as of a tool that is large beside the surface's cells: those that lie apart, by
/// a distance that lets most of the room be used. Which of two neighbours stays is the triangles' own, not how deep
/// they are, so that most of them are held again in the next iteration and the next tick: a choice that changes is a
/// force that leaps. (A maximal independent set by fixed priorities: Luby 1986.)
/// @param radius      of the tool [m]
/// @param contact_at  the contact on a triangle of `candidates`, or none
void choose_apart(const SurfacePatch& patch, const VectorX& x, double radius, std::span<const int> candidates,
                  const std::function<std::optional<Contact>(int)>& contact_at, ContactSet& out) noexcept;

/// The vertex of a contact that lies at one.
int vertex_of(const SurfacePatch& patch, const Contact& contact) noexcept;

/// Adds the same choice among contacts at vertices, without a mark: it is as one of larger cells.
/// @param found  not empty; comes back in another order      @param room  how many are added at most
void choose_vertices_apart(const SurfacePatch& patch, const VectorX& x, double radius, std::span<Contact> found,
                           int room, ContactSet& out) noexcept;

}  // namespace kt
