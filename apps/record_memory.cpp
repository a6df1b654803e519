#include "apps/record_memory.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <limits>
#include <string>

#include "core/base/error.hpp"

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

std::string bytes_text(double bytes) {
  char out[32];
  std::snprintf(out, sizeof out, bytes < 1e9 ? "%.3g MB" : "%.3g GB", bytes / (bytes < 1e9 ? 1e6 : 1e9));
  return out;
}

}  // namespace

double available_memory() { return std::max(0.0, std::min({of_machine(), of_control_group(), of_limit()})); }

double record_memory(const Scene& scene) {
  constexpr double kTick =
      900;  // an upper bound: a paper drag takes 0.3 kB; contacts, samples and the text of rows come on top
  return kTick * scene.duration * scene.local.rate_hz * (scene.second_tool ? 2 : 1);
}

void require_record_memory(const Scene& scene, double available) {
  const double needed = record_memory(scene);
  if (!(needed > 0.5 * available)) return;
  const std::string words = text("duration ", scene.duration, " s at local.rate_hz ", scene.local.rate_hz, " has ",
                                 scene.duration * scene.local.rate_hz, " ticks, whose records take ",
                                 bytes_text(needed), " of memory until the end; ", bytes_text(available),
                                 " are free, enough for ", scene.duration * available / needed, " s");
  if (needed > available) throw InputError(words + "; shorten the run, or lower local.rate_hz");
  std::cerr << "kilotouch: warning: " << words << '\n';
}

}  // namespace kt
