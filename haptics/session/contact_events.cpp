#include "haptics/session/contact_events.hpp"

namespace kt {

const char* name_of(ContactEventKind kind) {
  constexpr const char* kNames[] = {"touch", "release", "stick_to_slip", "slip_to_stick", "edge"};
  return kNames[static_cast<int>(kind)];
}

std::vector<ContactEvent> find_contact_events(std::span<const LocalFrame> frames) {
  std::vector<ContactEvent> out;
  LocalFrame before;
  for (const LocalFrame& now : frames) {
    const bool touched = before.mode != ContactMode::free, touches = now.mode != ContactMode::free;
    const LocalFrame& in_contact = touches ? now : before;
    const auto add = [&](ContactEventKind kind) {
      out.push_back({kind, now.t, in_contact.point, in_contact.force, in_contact.f_n, in_contact.f_t,
                     touched ? before.triangle : -1, touches ? now.triangle : -1});
    };
    if (touches != touched) {
      add(touches ? ContactEventKind::touch : ContactEventKind::release);
    } else if (touches) {
      const bool stuck = before.mode == ContactMode::stick, sticks = now.mode == ContactMode::stick;
      if (stuck != sticks) add(sticks ? ContactEventKind::slip_to_stick : ContactEventKind::stick_to_slip);
      if (now.triangle != before.triangle) add(ContactEventKind::edge);
    }
    before = now;
  }
  return out;
}

}  // namespace kt
