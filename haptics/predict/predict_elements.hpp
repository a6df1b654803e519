#pragma once
// What a mesh and its elements cannot do: keep their volume without locking, be crushed, be thin.
#include <optional>

#include "core/body/deformable_model.hpp"
#include "haptics/predict/predict.hpp"

namespace kt {

/// None when the model bends within a factor of 1.5 of what its material says.
/// @param element  tet4, tet10 or hex8, of fem
std::optional<Prediction> predict_locking(const DeformableModel& model, const std::string& element, double poisson);

/// None when a body of this model (msd, or the name of a material) comes back after being crushed to the share
/// `stretch` of its height (below 0: inside out).
std::optional<Prediction> predict_collapse(const std::string& model, double stretch);

}  // namespace kt
