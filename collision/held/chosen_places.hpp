#pragma once
// Held contacts that were chosen from more places than there is room for: between them the surface may reach into the
// tool. Contact::toi is of no use to a held contact otherwise, so it carries the mark.
#include <algorithm>

#include "collision/held/surface_contacts.hpp"

namespace kt {

inline constexpr double kChosenMark = 1;  ///< Contact::toi; of the other held contacts it is 0

/// Whether any of them stands for others beside it.
inline bool are_chosen(const ContactSet& contacts) noexcept {
  return std::any_of(contacts.begin(), contacts.end(), [](const Contact& c) { return c.toi == kChosenMark; });
}

}  // namespace kt
