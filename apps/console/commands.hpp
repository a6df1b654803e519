#pragma once
// One function per subcommand: adds itself to the command line; its callback does the work and sets the exit code.
// Wrong input is thrown as InputError, a failed run as RunError; main turns them into one line and exit code 2 or 1.
#include <CLI/CLI.hpp>
#include <atomic>

namespace kt {

void add_run_command(CLI::App& app, int& exit_code);
void add_replay_command(CLI::App& app, int& exit_code);
void add_compare_command(CLI::App& app, int& exit_code);
void add_view_command(CLI::App& app, int& exit_code);
void add_device_command(CLI::App& app, int& exit_code);
void add_serve_command(CLI::App& app, int& exit_code);
void add_touch_command(CLI::App& app, int& exit_code);
void add_key_command(CLI::App& app, int& exit_code);
void add_list_command(CLI::App& app, int& exit_code);
/// The commands of the laboratory, apart from the others on the page of help: lab/commands/.
void add_laboratory(CLI::App& app, int& exit_code);

/// Set by Ctrl-C: running commands end after the present tick and keep what they have.
const std::atomic<bool>& stop_requested();
/// The same from within: what runs cannot go on.
void request_stop();

}  // namespace kt
