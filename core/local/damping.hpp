#pragma once
// Whether the vibrations of a local model may be stepped each by itself: how much their damping couples them.
#include "core/local/local_model.hpp"

namespace kt {

/// No entry off the diagonal but zeros.
bool is_diagonal(const SparseMatrix& m);

/// Largest part of the damping power that any motion owes to the coupling between coordinates: the spectral norm of
/// d^-1/2 (D - d) d^-1/2, d the diagonal of D (power iteration, from below by a few per cent). 0: uncoupled, as with
/// Rayleigh damping in the coordinates of vibrations; infinity: mass or stiffness couple the coordinates too.
double damping_coupling(const LocalModel& model);

/// Keeps the diagonal of the damping only: passive like the whole, and off by damping_coupling().
void drop_coupling(LocalModel& model);

}  // namespace kt
