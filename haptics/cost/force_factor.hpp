#pragma once
// Force over the continuum's that cells under a tool give: fits to presses at rest. The ratio is that of a cell to the
// radius of the contact, sqrt(R d) of a ball pressed in by d (Hertz).
#include <string>

#include "core/body/deformable_model.hpp"

namespace kt {

constexpr double kCoarseForce = 1.25;  ///< factor of the continuum's force, or its inverse, that is told

/// Whose fit a model has: tet4, tet10, hex8, or msd (springs calibrated to a material). Empty: there is none.
std::string fitted_element(const ModelInfo& model);

/// Of cells as they are, for nu = 0.3 and ratios of 0.7 to 3, to a tenth (tests/haptics/contact_width_oracle_test.cpp).
/// NaN: there is no fit.
/// @param ratio      cell / contact radius [-], >= 0
/// @param is_smooth  the surface that is touched: stiffer on the same nodes, tet4 2.59 instead of 2.04, springs 1.59
///                   instead of 1.27, at 1.43
double coarse_force_factor(const std::string& element, double ratio, bool is_smooth = false);

/// Springs have no fit below: they converge to no continuum.
constexpr double kLeastSpringRatio = 0.7;

/// The ratio at which cells as they are have the factor.
double ratio_of_factor(const std::string& element, double factor);

/// Of refined cells (bench/fine_touch_table.cpp): within 0.07 for cells of up to 1.4 contact radii, and within 0.1 at a
/// Poisson's ratio of 0.48, 0.49 for cells of ten nodes. Springs give way more than the material where they are pressed
/// deeply: 0.71 to 0.98.
/// @param fineness    refined cell / contact radius [-]
/// @param is_lattice  the zone is no wider than it has to be: cells of four nodes around it lock more
double refined_force_factor(const ModelInfo& model, double fineness, bool is_lattice = false);

/// Of refined cells under a capsule that lies: 0.85 to 0.92 of a body that is fine everywhere, which itself is 4 to
/// 10 % too stiff (bench/fine_reference_table.cpp).
constexpr double kRefinedLine = 0.95;

}  // namespace kt
