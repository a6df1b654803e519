#pragma once
// Settings that a scene gives and nothing reads, because the chosen model, law, method or tool has no use for them.
#include <string>
#include <vector>

#include "io/scene/scene.hpp"

namespace kt {

/// One line each: key, value, what was chosen instead of what reads it. Only values that are not the defaults: those
/// are not asked for.
std::vector<std::string> unused_settings(const Scene& scene);

}  // namespace kt
