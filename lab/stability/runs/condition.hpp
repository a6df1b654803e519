#pragma once
#include "core/body/deformable_model.hpp"

namespace kt {

/// Condition number of the stiffness of the free nodes at rest, largest over smallest eigenvalue, to a few per cent: by
/// power iteration with the matrix and with its factor. Infinity when the stiffness is not positive definite.
double condition_number(const DeformableModel& model);

}  // namespace kt
