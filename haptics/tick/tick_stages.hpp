#pragma once
// The stages that Coulomb's tick and the paper's have in common, in their order.
#include <optional>

#include "haptics/tick/tick_state.hpp"

namespace kt {

// free_motion.cpp

/// Where the surface is at the start of the tick, and how it moves if nothing touches it.
void find_free_motion(TickState& tick) noexcept;

/// The part of the body's surface that the tick looks at goes with the tools.
/// @param at_end  of their sweeps, which are over; else all along these
/// @param moved   most that a coordinate of the patch has moved since the linearization [m]
void cover_tools(TickState& tick, bool at_end, double moved) noexcept;

/// Velocities of the surface from those of the patch's vertices.
void follow(const TickState& tick, const VectorX& patch, VectorX& out) noexcept;

/// Nothing was touched: the tick ends with the free motion.
void accept_free_motion(TickState& tick) noexcept;

// first_impact.cpp

/// The first impact of any tool, each along this part of its sweep, with the surface on its way from x_event to x_end;
/// of equal times that of the first tool.
std::optional<Contact> find_impact(TickState& tick, MovingTool TouchingTool::*part) noexcept;

/// Of one tool, with the index at hand.
std::optional<Contact> find_impact_of(const TickState& tick, int tool, const MovingTool& moving) noexcept;

/// The facet that a tool has got into unseen at the start of its sweep, as where neither patch nor apron reached; -1:
/// none. Where the slow side has found its way out, it is that one or near it. It is pushed out over some ticks: at
/// once would be a blow.
int find_overlap(TickState& tick, int tool, const MovingTool& moving) noexcept;

// tick_report.cpp

/// Where a contact is on the surface at x.
Vec3 place_of(const TickState& tick, const Contact& contact, const VectorX& x) noexcept;

/// Splits the tick's impulses of one tool into what is reported and what goes to the global side.
void report_contacts(TickState& tick, int tool, LocalFrame& frame) noexcept;

/// What leaves for the hand: no step at a refresh or while the body is pushed off the tool, and no fall where the tool
/// ran off the patch.
void shape_force(TickState& tick, int tool, LocalFrame& frame) noexcept;

}  // namespace kt
