#pragma once
// Where a command's words and its JSON go: standard output is the words', unless --json - asks for it.
#include <CLI/CLI.hpp>
#include <string>

namespace kt {

/// --quiet of a command: no words on standard output and no progress; errors and warnings stay on stderr.
void add_quiet_option(CLI::App& command);

/// Throws InputError for a file of an option that cannot be written, or that another process writes; no other one may
/// until this one ends. To be asked before any work.
void claim_output(const std::string& file, const std::string& option);

/// --json FILE of a command, which is asked before any work whether it can be written, and by no other process
/// meanwhile; with "-" standard output has the
/// JSON alone, and the words go to stderr.
CLI::Option* add_json_option(CLI::App& command, std::string& file, const std::string& what);

/// To the file as a whole, or for "-" to standard output; nothing for an empty name. Throws InputError.
void write_json(const std::string& file, const std::string& content);

bool is_quiet();

}  // namespace kt
