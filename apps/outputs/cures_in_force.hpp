#pragma once
// No finding is told with a cure that its scene already has.
#include "core/base/finding.hpp"
#include "io/scene/scene.hpp"

namespace kt {

/// The cure changes the scene, and leaves it one that can be run; an action that is no setting always counts.
bool changes(const Scene& scene, const Cure& cure);

/// Without the cures that change nothing.
std::vector<Finding> with_true_cures(const Scene& scene, std::vector<Finding> findings);

}  // namespace kt
