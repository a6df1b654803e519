#pragma once
// What the haptic side reports after each tick.
#include <array>

#include "collision/surface_contacts.hpp"
#include "core/global_simulation.hpp"

namespace kt {

/// Of one tool.
struct ToolReport {
  Vec3 place = Vec3::Zero();  ///< [m]
  int triangle = -1;          ///< in contact: which surface triangle
  bool sliding = false;       ///< the contact that carries most slid
};

struct LocalReport {
  int tick = 0;  ///< index of the tick that ended
  std::array<ToolReport, kMaxTools> tools{};
  bool left_patch = false;  ///< a tool is at the edge of the local model: a new one is wanted at once
  int count = 0;
  std::array<ContactSample, kMaxContacts> samples{};  ///< of all tools
};

}  // namespace kt
