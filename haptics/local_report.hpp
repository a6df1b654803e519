#pragma once
// What the haptic side reports after each tick.
#include <array>

#include "collision/surface_contacts.hpp"
#include "core/global_simulation.hpp"

namespace kt {

struct LocalReport {
  int tick = 0;              ///< index of the tick that ended
  Vec3 tool = Vec3::Zero();  ///< [m]
  int triangle = -1;         ///< in contact: which surface triangle
  bool sliding = false;      ///< the contact that carries most slid
  bool left_patch = false;   ///< the tool is at the edge of the local model: a new one is wanted at once
  int count = 0;
  std::array<ContactSample, kMaxContacts> samples{};
};

}  // namespace kt
