#pragma once
// Settings that a scene gives and nothing reads, because the chosen model, law, method or tool has no use for them.
#include <vector>

#include "core/base/finding.hpp"
#include "io/scene/scene.hpp"

namespace kt {

/// Each a note with its key: value, what was chosen instead of what reads it. Only values that are not the defaults:
/// those are not asked for. Choices by a word are those of the schema's "read_by"; the others stand here.
std::vector<Finding> unused_settings(const Scene& scene);

}  // namespace kt
