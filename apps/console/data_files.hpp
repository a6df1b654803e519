#pragma once
#include <filesystem>

namespace kt {

/// A file or folder that comes with the command, as scenes/chart_drag.json or report.py: in the source tree, if this
/// build knows one (KT_SOURCE_DATA), else in share/kilotouch beside the installed command. Empty: in neither.
std::filesystem::path find_data(const std::filesystem::path& name);

}  // namespace kt
