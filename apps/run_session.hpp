#pragma once
// Runs a scene for a command: progress bar, Ctrl-C, allocation count, outputs, report.
#include <nlohmann/json.hpp>
#include <string>

#include "haptics/session/session.hpp"
#include "haptics/study/reference.hpp"

namespace kt {

/// Whether and how a run is compared with the full model.
struct ReferenceSettings {
  bool compute = false;
  double rate_hz = 10000;
  std::string file;   ///< one computed before; empty: none
  std::string truth;  ///< one of another body, law or mesh, along the same path; empty: none
};

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
  ReferenceSettings reference;
};

struct RunOutcome {
  nlohmann::ordered_json summary;
  SessionResult result;
};

/// 1 when something was found by which the forces are not those of the scene, as in the summary's trust.failed.
int run_exit_code(const RunOutcome& outcome);

/// Throws InputError and RunError.
RunOutcome run_scene(const Scene& scene, RunSettings settings);

/// A bar with the time left on stderr, when that is a terminal; else nothing, or a plain line every ten seconds.
std::function<void(double)> progress_bar(const std::string& title, Piped piped = Piped::silent);

}  // namespace kt
