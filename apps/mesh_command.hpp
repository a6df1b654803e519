#pragma once
// `kilotouch mesh info|repair|tet MESH [-o OUT]`.
#include <CLI/CLI.hpp>

namespace kt {

/// Adds the subcommand. Its callbacks throw InputError (wrong input) and RunError (a backend failed) and write
/// exit_code 0 otherwise: defects that `info` finds are a result, not a failure.
void add_mesh_command(CLI::App& app, int& exit_code);

}  // namespace kt
