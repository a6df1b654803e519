#pragma once
// The contact of a capsule that lies: longer than it is wide.
#include <optional>
#include <span>

#include "collision/shape/tool_shape.hpp"
#include "haptics/tick/tick_contact.hpp"

namespace kt {

struct ContactLength {
  Vec3 middle = Vec3::Zero();              ///< of the contacts by force [m]
  Vec3 along = Vec3::Zero();               ///< unit
  double half_length = 0, half_width = 0;  ///< [m]
};

/// What pushes the body along the contact's normal [N s].
double push_of(const TickContact& contact);

/// Half a length over half a width from which on a contact is long, and below which one that was is no longer.
constexpr double kLong = 2.2, kStaysLong = 1.6;

/// From where the tool's force was distributed over in a tick: a pressure that is even along the contact and half an
/// ellipse across has mean squares of a third and a quarter. None: of other shapes, of fewer than three contacts, and
/// of one that is shorter than kStaysLong.
/// @param turned  how the tool is turned
std::optional<ContactLength> contact_length(const ToolShape& shape, const Quaternion& turned,
                                            std::span<const TickContact> contacts, int tool);

}  // namespace kt
