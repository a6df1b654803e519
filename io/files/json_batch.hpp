#pragma once
// Many runs of programs that each write one JSON file: side by side, with limits, and so that nothing that is done is
// lost. Every result is one line of a file as soon as it is there; a batch that was killed goes on where it stopped.
#include <nlohmann/json.hpp>

#include "io/files/child_process.hpp"

namespace kt {

/// One piece of work. `arguments`: the program and its words; "{json}" among them stands for the file it is to write.
struct BatchJob {
  std::string key;  ///< names the row; no two jobs of a batch share one
  std::vector<std::string> arguments;
  std::vector<std::string> after =
      {};  ///< keys of jobs earlier in the batch: begins when these have ended, well or not
  std::vector<std::string> inputs = {};  ///< files that the result depends on: a row holds while their content and the
                                         ///< words beside their names are the same; none: while its key is
};

struct BatchOptions {
  std::string file;     ///< of the rows, one JSON object a line (JSON lines)
  bool resume = false;  ///< rows that the file holds already, and whose inputs are as they were, are not made again (a
                        ///< row of the same inputs under another key is that of a renamed file); else it begins empty
  int jobs = 1;         ///< programs at a time
  ChildLimits limits;   ///< of each; its `stop` ends the batch: what is under way then leaves no row
  std::function<void(double)> progress = {};  ///< share done, 0..1; from one thread at a time
};

/// Runs what has no row yet. Each row has
///   key, outcome ("done", "error": exit code not 0, "crash", "timeout", "memory"), exit_code, trouble (empty when
///   done), seconds (wall clock), inputs (a hash of what it depends on; empty: only its key), result (what the program
///   wrote, also when it failed after that; null without).
/// @returns the rows in the order of the jobs; those that `stop` left out are missing.
/// @throws InputError for two jobs of one key, `after` a job that does not come before, a file that cannot be written
/// or read, and one that another batch has open.
std::vector<nlohmann::ordered_json> run_batch(const std::vector<BatchJob>& jobs, const BatchOptions& options);

/// The rows of a batch's file, without a last line that was cut off. @throws InputError naming file and line.
std::vector<nlohmann::ordered_json> read_batch(const std::string& file);

}  // namespace kt
