#pragma once
// Where a surface already passes through itself: a barrier cannot part what has crossed.
#include "self_contact/touching_model.hpp"

namespace kt {

/// Two triangles that cross or touch where they have no common node.
struct Crossing {
  std::array<int, 2> triangles{};  ///< ascending
  Vec3 at = Vec3::Zero();          ///< [m]
  bool only_touches = false;       ///< no edge of one goes through the other
};

/// All of them at the positions x, (3n), by triangle numbers. Nearer than a millionth of the contact's reach is a
/// touch: there the barrier's force is beyond any use, and rounding cannot tell on which side a node is.
std::vector<Crossing> find_crossings(SelfContact& contact, std::span<const Triangle> triangles, const VectorX& x);

/// Only those whose edges go through triangles, of a surface that nothing keeps apart. A hundred thousand triangles
/// take some tenths of a second.
std::vector<Crossing> find_piercings(std::span<const Triangle> triangles, const VectorX& x);

}  // namespace kt
