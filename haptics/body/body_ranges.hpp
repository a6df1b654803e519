#pragma once
#include "haptics/body/body.hpp"

namespace kt {

/// Throws InputError for a number that is out of the range that the scene's schema has for it: options may come from
/// code.
void check_ranges(const BodyOptions& options);

/// What a body of a lattice does not go with, one line with the cure; empty: nothing.
std::string why_no_lattice(const BodyOptions& options);

}  // namespace kt
