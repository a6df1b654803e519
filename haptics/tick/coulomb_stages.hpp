#pragma once
// The stages of Coulomb's tick from one event to the next, in their order.
#include "haptics/tick/tick_state.hpp"

namespace kt {

// coulomb_fixed_point.cpp

/// The contacts and their impulses for the rest of the tick: TickState::contacts and solution, the surface at x_end.
void resolve_contacts(TickState& tick) noexcept;

/// Where the surface is after the rest of the tick with the motion that is known so far.
void place_surface(const TickState& tick, VectorX& out) noexcept;

/// Response of the contacts to one another's impulses, from that of the patch's vertices.
void couple_contacts(PreparedLocalModel& model, const ContactSet& contacts, const MatrixX& C,
                     ContactMatrix& out) noexcept;

/// Impulses of all contacts at the patch's vertices, and the motion of the patch that they cause.
void spread_impulses(TickState& tick) noexcept;

// coulomb_places.cpp

/// Where the surface at x touches the tools or nearly does; of the tools that touch, another one is found when it hits.
void find_contacts(TickState& tick, const VectorX& x, ContactSet& out) noexcept;

/// The triangles that the tools can reach in the rest of the tick are all ignored: those looked for near the guess, if
/// the surface ends close enough to it.
bool is_nothing_left_to_hit(const TickState& tick) noexcept;

/// Lets go of places of tools with edges that the solver need not hold, since its time grows with their number, and
/// most where two are nearly one: those that nothing has pushed at and that stay clear, and those close beside a deeper
/// one, which carries their force a little aside. What is reached after all is seen when gaps are closed, as that looks
/// at all of them.
/// @param before  that the last solution, or the last tick, pushed at
void drop_clear_places(const TickState& tick, const ContactSet& before, ContactSet& contacts) noexcept;

/// Adds the places that the last iteration pushed at and that are not found any more: every place of the surface must
/// stay outside the tool, so both are held from then on (the exchange method for as many constraints as places:
/// Hettich and Kortanek 1993).
/// @param before  contacts of the last iteration, which TickState::solution is of
void keep_pushing(const TickState& tick, const ContactSet& before, ContactSet& contacts) noexcept;

/// Starts the solver from the impulses that the same triangles carried before; of a tool with edges, that the nearest
/// place of it did.
void warm_start(const TickState& tick, const ContactSet& before, ContactVector& impulse) noexcept;

// coulomb_gaps.cpp

/// Scales the impulses until the tool lies on the surface to the last digits. They keep their directions, hence their
/// place in the cone of friction; what changes is within the accuracy to which they are known.
/// False when the tool touches elsewhere than where the impulses act: they have to be found anew.
bool close_gaps(TickState& tick) noexcept;

// coulomb_velocities.cpp

/// The second impulse at the end of the tick: along the normal, and along the surface too where it sticks. Where it
/// slides the impulse keeps its direction, and so its place in the cone of friction. Left out where a contact would
/// come to pull, or a sticking one to slide.
void settle_velocities(TickState& tick) noexcept;

}  // namespace kt
