#pragma once
// Which contact of a tool with edges is which, from one moment to the next.
#include "collision/shape/contact.hpp"

namespace kt {

/// Squared distance of the places of a tool's surface that two contacts touch [m^2]: what tells the contacts of an
/// extended tool apart. The triangle does not: a place over an edge may count to either of two from one moment to the
/// next.
inline double apart_on_tool_sq(const Contact& a, const Contact& b, double radius) noexcept {
  return (a.core - radius * a.normal - b.core + radius * b.normal).squaredNorm();
}

}  // namespace kt
