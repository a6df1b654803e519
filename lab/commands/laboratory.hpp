#pragma once
// The commands of the laboratory; as apps/console/commands.hpp.
#include <CLI/CLI.hpp>

namespace kt {

void add_paper_command(CLI::App& app, int& exit_code);
void add_advise_command(CLI::App& app, int& exit_code);
void add_chart_command(CLI::App& app, int& exit_code);
void add_stability_command(CLI::App& app, int& exit_code);
void add_check_command(CLI::App& app, int& exit_code);

}  // namespace kt
