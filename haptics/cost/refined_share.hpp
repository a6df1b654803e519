#pragma once
// How much of a contact's yield is that of the refined cells, and how much that of the body as it is. Under a tool on a
// thin part the body bends away, and what the cells under it are like matters little.
#include <span>

#include "core/local/local_model.hpp"
#include "haptics/tick/tick_contact.hpp"

namespace kt {

/// Of the work of the contacts' forces on a body at rest, the share that goes into the refined cells, in [0, 1]:
/// f R f / f (S + R) f, with S the compliance of the local model, and R that of its fine patch (method.md, in series).
/// 0 where the body gives way without end.
/// @param contacts  on triangles of the body's surface
/// NaN without refined cells, or without a contact on them.
double refined_share(const LocalModel& model, std::span<const TickContact> contacts);

}  // namespace kt
