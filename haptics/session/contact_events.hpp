#pragma once
// What happened to a contact, and when: touched, let go, stuck, slid, went over an edge. For logs and tests.
#include <span>

#include "haptics/tick/local_simulation.hpp"

namespace kt {

enum class ContactEventKind { touch, release, stick_to_slip, slip_to_stick, edge };
const char* name_of(ContactEventKind kind);

/// Of the contact that carries most, at the end of the tick in which it was so for the first time.
struct ContactEvent {
  ContactEventKind kind = ContactEventKind::touch;
  double t = 0;               ///< [s]
  Vec3 place = Vec3::Zero();  ///< of the contact on the tool [m]; at a release where it was last
  Vec3 force = Vec3::Zero();  ///< on the tool [N]; at a release the last one
  double f_n = 0, f_t = 0;    ///< its parts [N]
  int triangle_before = -1;   ///< -1: none
  int triangle = -1;
};

/// Ascending in time. With static friction, `slide` (no friction at all) counts as slip. One tick may give two events:
/// an edge that is crossed as it begins to slip.
std::vector<ContactEvent> find_contact_events(std::span<const LocalFrame> frames);

}  // namespace kt
