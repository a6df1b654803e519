#pragma once
#include "core/base/types.hpp"

namespace kt {

/// What the local side did to the body during one haptic tick at one contact. The nodes that moved with it are found on
/// the slow side, which knows the local model (refresh/contact_nodes.hpp).
struct TickContact {
  double t = 0;                 ///< start of the tick [s]
  int triangle = -1;            ///< of the body's surface
  int facet = -1;               ///< of the local model's contact surface, which may be smooth; -1: the triangle itself
  Vec3 bary = Vec3::Zero();     ///< where on that
  Vec3 impulse = Vec3::Zero();  ///< given to the body during the tick [N s]
  Vec3 normal = Vec3::Zero();   ///< unit, from the body towards the tool
  Vec3 point = Vec3::Zero();    ///< contact point at the end of the tick [m]
  bool sticks = false;          ///< the contact point went with the tool
  int tool = 0;                 ///< which one of those that touch the body
};

}  // namespace kt
