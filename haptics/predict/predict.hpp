#pragma once
// Failures that can be told before a run: a scene outside the stable region of one of its methods, and which setting
// brings it back. Table: predictions.def; each line is measured against a map of `kilotouch stability`
// (docs/stability.md).
#include <string>
#include <vector>

#include "core/base/finding.hpp"
#include "core/base/numbers.hpp"

namespace kt {

class BuiltScene;

struct Prediction {
  std::string failure;  ///< the map that shows it: time_step, poisson, ...
  Finding finding;      ///< what, value, limit, and which setting to change to what

  std::string message() const { return finding.line(); }
};

/// Everything that is known to fail in the scene as it is set up; empty for a good one. Far below a second: at most a
/// few products with the body's tangent.
std::vector<Prediction> predict_failures(const BuiltScene& built);

#define PREDICTION(name) void predict_##name(const BuiltScene& built, std::vector<Prediction>& out);
#include "haptics/predict/predictions.def"

}  // namespace kt
