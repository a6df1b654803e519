#pragma once
// Runs a scene for a command: progress bar, Ctrl-C, allocation count, outputs, report.
#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "haptics/session/session.hpp"

namespace kt {

struct RunOutcome {
  nlohmann::ordered_json summary;
  SessionResult result;
};

/// What compares a run with a better one (lab/commands/reference_options.cpp).
class RunComparison {
 public:
  virtual ~RunComparison() = default;
  virtual bool is_asked() const = 0;  ///< by the command line
  /// Before anything is built. @throws InputError for what a wrong word would spoil
  virtual void prepare(Scene& scene) = 0;
  virtual void check(const Session& session) = 0;                      ///< the same before the run
  virtual void complete(const Session& session, RunOutcome& run) = 0;  ///< adds to the summary
  virtual void write(const std::string& folder) = 0;
};

/// --reference, --reference-rate, --reference-file and --truth of a command, in builds with the laboratory.
std::shared_ptr<RunComparison> add_reference_options(CLI::App& command);

/// Of progress where stderr is no terminal.
enum class Piped { silent, lines };

struct RunSettings {
  std::string out;        ///< folder for the results; empty: none are written
  std::string json_file;  ///< also the summary alone; empty: no
  bool force = false;     ///< another scene's results in `out` may be replaced
  bool states = false;    ///< VTU and PVD of the snapshots
  bool report = true;     ///< pictures and report.html
  std::string figures;    ///< svg or pdf: the pictures as vectors, too
  bool quiet = false;     ///< no summary on standard output
  bool details = false;   ///< a summary of every figure, not the first screen alone
  Piped piped = Piped::silent;
  std::string reproduce;  ///< the command, for the report
  SceneFiles files;       ///< of a session: what its scene names, as it was
  std::string input;      ///< the file that the scene or its mesh came from, for messages
  SessionOptions session;
  std::function<std::vector<Finding>()> found;  ///< what the caller knows against the run, when it is over
  std::function<void(nlohmann::ordered_json& summary)> complete;  ///< with what the caller knows of the run
  std::shared_ptr<RunComparison> comparison = {};
};

/// 1 when something was found by which the forces are not those of the scene, as in the summary's trust.failed.
int run_exit_code(const RunOutcome& outcome);

/// Throws InputError and RunError.
RunOutcome run_scene(Scene scene, RunSettings settings);

/// A bar with the time left on stderr, when that is a terminal; else nothing, or a plain line every ten seconds.
std::function<void(double)> progress_bar(const std::string& title, Piped piped = Piped::silent);

}  // namespace kt
