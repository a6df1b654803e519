#include "apps/console/report.hpp"

#include <unistd.h>

#include <filesystem>
#include <iostream>

#include "apps/console/commands.hpp"
#include "apps/console/data_files.hpp"
#include "apps/console/stop_signals.hpp"
#include "core/base/error.hpp"
#include "io/files/child_process.hpp"

namespace kt {
namespace {

namespace fs = std::filesystem;

constexpr int kPackageMissing = 3;  // exit status of the script when it made what it could without a package

bool warn(const std::string& dir, const std::string& why) {
  std::cerr << text("kilotouch: warning: no pictures: ", why, "; the numbers are in ", dir, '\n');
  return false;
}

/// The script's own last line: which package, and what there is without it.
bool say_what_is_missing(std::string words) {
  while (words.ends_with('\n')) words.pop_back();
  const std::string line = words.substr(words.rfind('\n') + 1), prefix = "report.py: ";
  std::cerr << text("kilotouch: warning: ", line.starts_with(prefix) ? line.substr(prefix.size()) : line, '\n');
  return false;
}

/// The child works in a folder of its own.
std::string absolute(const std::string& path) { return fs::absolute(path).lexically_normal().string(); }

bool run_script(const std::string& dir, std::vector<std::string> options, const ReportSettings& settings) {
  const std::string script = find_data("report.py").string();
  if (script.empty()) return warn(dir, "report.py is not in share/kilotouch beside the program's bin");
  if (::access(settings.python.c_str(), X_OK) != 0)
    return warn(dir, text(settings.python, " is missing (Debian: python3-matplotlib)"));
  std::vector<std::string> arguments = {settings.python, script, absolute(dir)};
  if (!settings.title.empty()) options.push_back("--title=" + settings.title);
  arguments.insert(arguments.end(), options.begin(), options.end());

  const PrivateFolder folder;
  // Address space, not memory: NumPy's libraries reserve far more than they touch.
  const ChildLimits limits{
      .seconds = settings.seconds, .memory_bytes = std::size_t{32} << 30, .stop = &stop_requested()};
  ChildResult result;
  try {
    result = run_program(arguments, folder, limits);
  } catch (const RunError&) {
    if (!stop_requested()) throw;
    return warn(dir, text("stopped by ", stop_signal_name()));
  }
  if (result.exit_code == kPackageMissing) return say_what_is_missing(result.output);
  return result.good() || warn(dir, "report.py " + result.trouble(limits));
}

}  // namespace

bool write_report(const std::string& dir, const ReportSettings& settings) {
  std::vector<std::string> options;
  if (!settings.figures.empty()) options.push_back("--figures=" + settings.figures);
  return run_script(dir, options, settings);
}

bool write_paper_report(const std::string& dir, const ReportSettings& settings) {
  return run_script(dir, {"--paper"}, settings);
}

bool write_chart_report(const std::string& dir) { return run_script(dir, {"--chart"}, {}); }

bool write_stability_report(const std::string& dir, const ReportSettings& settings) {
  return run_script(dir, {"--stability"}, settings);
}

bool write_check_page(const std::string& dir) { return run_script(dir, {"--check"}, {.seconds = 600}); }

bool write_compare_page(const std::string& dir) { return run_script(dir, {"--compare"}, {}); }

}  // namespace kt
