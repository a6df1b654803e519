#pragma once
// What a message between two computers keeps of a value. Both sides use it rounded so: the one that sends books what
// the other one gets, and a replay in one process has the same bits.
#include <cstdint>

#include "haptics/tick/local_motion.hpp"
#include "haptics/tick/local_report.hpp"

namespace kt {

/// Impulses travel as whole numbers of this: their sums are exact in whatever order they are added.
constexpr double kImpulseQuantum = 0x1p-30;        ///< [N s], 1 uN over a tick of 1 ms
constexpr double kMostImpulse = 2;                 ///< [N s] of a contact in a tick: 2000 N over 1 ms; more is cut
using ImpulseCount = std::array<std::int64_t, 3>;  ///< in quanta

/// Of a finite impulse.
ImpulseCount count_impulse(const Vec3& impulse) noexcept;
Vec3 impulse_of(const ImpulseCount& count) noexcept;

/// Impulses in quanta; places on triangles, normals, points and turns as 32-bit numbers; contacts begin with the tick.
/// The tool's place stays whole.
/// @param h  of a tick [s]
LocalReport as_sent(const LocalReport& report, double h) noexcept;

/// Positions, velocities and contact motion as 32-bit numbers. In place.
void round_as_sent(LocalMotion& motion) noexcept;

}  // namespace kt
