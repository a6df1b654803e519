#include "apps/run/record_room.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <string>

#include "core/base/numbers.hpp"
#include "core/base/record.hpp"
#include "core/base/temporary_folder.hpp"

namespace kt {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

/// The number behind a word of a file of the kernel; infinite without.
double number_in(const std::string& file, const std::string& word) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);)
    if (line.starts_with(word)) {
      const char* const digits = line.c_str() + word.size();
      char* end = nullptr;
      const double value = std::strtod(digits, &end);
      return end == digits ? kNone : value;
    }
  return kNone;
}

double of_machine() { return 1024 * number_in("/proc/meminfo", "MemAvailable:"); }

/// Control groups, version 2: this process's own and those above it.
double of_control_group() {
  std::ifstream in("/proc/self/cgroup");
  std::string line, path;
  while (std::getline(in, line))
    if (line.starts_with("0::")) path = line.substr(3);
  double out = kNone;
  for (; !path.empty(); path.erase(path.rfind('/'))) {
    const std::string folder = "/sys/fs/cgroup" + (path == "/" ? "" : path);
    const double most = number_in(folder + "/memory.max", "");
    if (std::isfinite(most)) out = std::min(out, most - number_in(folder + "/memory.current", ""));
  }
  const double root = number_in("/sys/fs/cgroup/memory.max", "");  // as a container sees its own
  return std::isfinite(root) ? std::min(out, root - number_in("/sys/fs/cgroup/memory.current", "")) : out;
}

double of_limit() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kNone;
  const double pages = number_in("/proc/self/statm", "");
  return static_cast<double>(limit.rlim_cur) - pages * static_cast<double>(::sysconf(_SC_PAGESIZE));
}

double of_memory() { return std::max(0.0, std::min({of_machine(), of_control_group(), of_limit()})); }

/// [bytes] free on the disk of the folder, or of the nearest one above that is there.
double of_disk(const std::string& folder) {
  std::error_code error;
  std::filesystem::path path = std::filesystem::absolute(folder, error);
  while (!std::filesystem::exists(path, error) && path.has_relative_path()) path = path.parent_path();
  const std::filesystem::space_info space = std::filesystem::space(path, error);
  return error ? kNone : static_cast<double>(space.available);
}

}  // namespace

Room free_room(const std::string& results) {
  return {of_memory(), of_disk(temporary_folder("/var/tmp")), results.empty() ? kNone : of_disk(results)};
}

Room needed_room(const Scene& scene, bool keeps_results) {
  if (scene.is_endless) return {};
  // Upper bounds: of a tool and tick its frame and its force; figures of it (forces, times); its rows of text.
  constexpr double kRecord = 450, kFigures = 150, kText = 700;  // [bytes]
  const double ticks = scene.duration * scene.local.rate_hz, tools = scene.second_tool ? 2 : 1;
  const double records = kRecord * tools * ticks;
  return {kFigures * tools * ticks, records > RecordBytes::kInMemory ? records : 0,
          keeps_results ? kText * tools * ticks : 0};
}

void require_room(const Scene& scene, const Room& needed, const Room& free) {
  const auto require = [&](const std::string& what, double needed_bytes, double free_bytes) {
    if (!(needed_bytes > 0.5 * free_bytes)) return;
    const std::string words =
        told("duration ", scene.duration, " s at local.rate_hz ", scene.local.rate_hz, " has ",
             scene.duration * scene.local.rate_hz, " ticks, ", what, " take ", in_unit(needed_bytes, "B"), "; ",
             in_unit(free_bytes, "B"), " are free, enough for ", scene.duration * free_bytes / needed_bytes, " s");
    if (needed_bytes > free_bytes) throw InputError(words + "; shorten the run, or lower local.rate_hz");
    std::cerr << "kilotouch: warning: " << words << '\n';
  };
  require("whose figures in memory", needed.memory, free.memory);
  require("whose records in " + RecordBytes::folder() + " ($TMPDIR)", needed.records, free.records);
  require("whose tables on the disk of the results", needed.results, free.results);
}

}  // namespace kt
