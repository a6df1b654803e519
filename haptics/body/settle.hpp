#pragma once
// Where a body is when it is touched first: a body with weight has hung in it before.
#include "haptics/body/body.hpp"

namespace kt {

/// The equilibrium in its weight; undeformed without one, and where it does not bear it, which is a warning. A body
/// without a clamped part falls: it starts undeformed.
/// @param self_contact  none: it passes through itself
State settle(const BodyOptions& options, const DeformableModel& model, SelfContact* self_contact,
             std::vector<Finding>& findings);

}  // namespace kt
