#pragma once
#include <string>

namespace kt {

/// Where temporary files go: $TMPDIR, or the usual place where that is empty or not set.
/// @throws InputError: there is no such folder
std::string temporary_folder(const std::string& usual = "/tmp");

}  // namespace kt
