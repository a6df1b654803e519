#pragma once
// How much of a contact's yield is that of the refined cells, and how much that of the body as it is. Under a tool on a
// thin part the body bends away, and what the cells under it are like matters little.
#include <span>

#include "core/local/local_model.hpp"
#include "haptics/tick/tick_contact.hpp"

namespace kt {

/// Of the work of the contacts' forces over a tenth of a second, the share that goes into the refined cells, in [0, 1]:
/// f R f / f (S + R) f, with S = 1 / (stiffness + mass / (0.1 s)^2) the compliance of the local model, and R that of
/// its fine patch, in series (docs/method.md). Inertia holds a body that floats, or swings slowly.
/// @param contacts  on triangles of the body's surface
/// NaN without refined cells, without a contact on them, or where the body has no answer.
double refined_share(const LocalModel& model, std::span<const TickContact> contacts);

}  // namespace kt
