#pragma once
// A run keeps its records in memory until the end: whether they fit is known before it begins.
#include "io/scene/scene.hpp"

namespace kt {

/// Memory that this process may still take [bytes]: of the machine, its control group and its own limit, the least;
/// infinite where nothing says.
double available_memory();

/// What the records of a run take [bytes].
double record_memory(const Scene& scene);

/// Throws InputError when the records take more than there is, and warns on stderr when they take over half of it.
void require_record_memory(const Scene& scene, double available);

}  // namespace kt
