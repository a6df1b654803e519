#pragma once
// What the haptic side reports after each tick.
#include <algorithm>
#include <array>
#include <span>

#include "collision/held/surface_contacts.hpp"
#include "haptics/tick/tick_contact.hpp"

namespace kt {

/// Of one tool.
struct ToolReport {
  Pose pose;
  int triangle = -1;     ///< in contact: which surface triangle
  bool sliding = false;  ///< the contact that carries most slid
};

struct LocalReport {
  int tick = 0;  ///< index of the tick that ended
  std::array<ToolReport, kMaxTools> tools{};
  bool left_patch = false;  ///< a tool is at the edge of the local model: a new one is wanted at once
  int model_frame = -1;     ///< of the local model that was in use
  int count = 0;
  std::array<TickContact, kMaxContacts> samples{};  ///< of all tools; those from count on: anything

  LocalReport() = default;
  LocalReport(const LocalReport& other) noexcept { *this = other; }
  LocalReport& operator=(const LocalReport& other) noexcept {  // no more than there is: every tick is copied
    tick = other.tick;
    tools = other.tools;
    left_patch = other.left_patch;
    model_frame = other.model_frame;
    count = other.count;
    std::copy_n(other.samples.begin(), count, samples.begin());
    return *this;
  }
  std::span<const TickContact> contacts() const noexcept { return {samples.data(), static_cast<std::size_t>(count)}; }
};

}  // namespace kt
