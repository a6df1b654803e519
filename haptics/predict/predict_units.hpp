#pragma once
// Sizes and stiffnesses that are mostly a slip of units: a mesh in millimetres, a modulus in kPa.
#include <optional>

#include "core/body/mesh.hpp"
#include "haptics/predict/predict.hpp"
#include "io/scene/scene.hpp"

namespace kt {

/// What the scene's numbers come to in metres.
struct SceneSizes {
  Bounds body;                        ///< [m]
  double mesh_unit = 1;               ///< of the file [m]
  Vec3 tool = Vec3::Zero();           ///< extents of the first tool, ascending [m]
  std::optional<Vec3> second_tool{};  ///< the same
  double depth = 0;                   ///< of the press, 0: not known [m]
  double thickness = 0;               ///< of the body under the press, 0: not known [m]
};

/// One line each: body outside 5 mm to 1 m, tool wider than the body is long, press deeper than 0.3 of the thickness,
/// Young's modulus outside 100 Pa to 1 GPa. A tool's width is the middle one of its extents: a needle may be long.
std::vector<Prediction> predict_units(const Scene& scene, const SceneSizes& sizes);

}  // namespace kt
