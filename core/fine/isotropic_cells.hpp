#pragma once
// Isotropic linear solids that turn with the body: what springs stand for, and models that tell nothing of a material.
#include <memory>

#include "core/body/refinable.hpp"

namespace kt {

Moduli isotropic_moduli(double young, double poisson, const Mat3& rotation = Mat3::Identity());

/// The rotation nearest to F, of an F turned inside out, too.
Mat3 nearest_rotation(const Mat3& F);

/// For a model that tells nothing: a linear solid of the "young" and "poisson" in its info(), with the retardation of
/// its "damping_stiffness" (absent: none). Throws InputError where it names neither, has no tetrahedra or has nodes
/// that are no corner of one.
std::unique_ptr<Refinable> isotropic_cells(const DeformableModel& model);

}  // namespace kt
