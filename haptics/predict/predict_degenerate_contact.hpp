#pragma once
// A tool that begins inside the body, and surface triangles without area.
#include <optional>
#include <string>

#include "core/body/mesh.hpp"
#include "haptics/predict/predict.hpp"

namespace kt {

/// None when the surface's triangles have heights above roundoff.
std::optional<Prediction> predict_flat_triangles(const VectorX& x, const std::vector<Triangle>& triangles);

/// None when the tool's deepest point is no further than `depth` = roundoff inside the body.
/// @param way_out  where the body is pushed off it [m]; none: it is not (the paper's laws, or all is clamped)
std::optional<Prediction> predict_start_inside(double depth, const std::optional<Vec3>& way_out,
                                               bool touches_at_once = false, const std::string& key = "tool.path");

}  // namespace kt
