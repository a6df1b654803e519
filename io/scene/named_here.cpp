#include "io/scene/named_here.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "core/base/error.hpp"
#include "core/base/loopback.hpp"
#include "core/base/visible_text.hpp"

namespace kt {
namespace {

namespace fs = std::filesystem;

std::vector<std::pair<std::string, SceneTool*>> tools_of(Scene& scene) {
  std::vector<std::pair<std::string, SceneTool*>> out{{"tool", &scene.tool}};
  if (scene.second_tool) out.emplace_back("second_tool", &*scene.second_tool);
  return out;
}

/// Whether only root and this user can change the file: it and each folder above it are theirs, and others cannot write
/// there (in a folder as /tmp they can, but not in what lies in it).
bool is_written_by_nobody_else(const fs::path& file) {
  std::error_code error;
  for (fs::path at = fs::canonical(file, error); !error && !at.empty(); at = at.parent_path()) {
    struct stat s {};
    if (stat(at.c_str(), &s) != 0) return false;
    const bool is_ours = s.st_uid == 0 || s.st_uid == geteuid();
    if (!is_ours || ((s.st_mode & S_IWOTH) != 0 && (s.st_mode & S_ISVTX) == 0)) return false;
    if (at == at.root_path()) return true;
  }
  return false;
}

/// A plain name is looked for by the system's loader, never in the current folder. /proc and /dev have paths that stand
/// for the current folder.
bool is_installed_library(const std::string& library) {
  if (library.find('/') == std::string::npos) return true;
  const fs::path path = fs::path(library).lexically_normal();
  if (!path.is_absolute()) return false;
  const fs::path top = *std::next(path.begin());
  if (top == "proc" || top == "dev") return false;
  std::error_code none;
  return !fs::exists(path, none) || is_written_by_nobody_else(path);
}

/// "ws://127.0.0.1:10001", or a socket's absolute path.
bool is_own_address(const std::string& address) {
  if (address.front() == '/') return true;
  const std::size_t start = address.find("://");
  if (start == std::string::npos) return false;
  const std::string rest = address.substr(start + 3);
  const std::size_t bracket = rest.starts_with('[') ? rest.find(']') : std::string::npos;
  return is_loopback(bracket != std::string::npos ? rest.substr(1, bracket - 1) : rest.substr(0, rest.find(':')));
}

bool is_library(const NamedPlace& named) { return named.key.ends_with(".library"); }

bool may_name(const NamedPlace& named, SceneDoor door) {
  if (door == SceneDoor::others) return false;
  return is_library(named) ? is_installed_library(*named.place) : is_own_address(*named.place);
}

const char* rule_of(const NamedPlace& named, SceneDoor door) {
  if (door == SceneDoor::others)
    return is_library(named) ? "a library is code, named by this computer alone"
                             : "an address is named by this computer alone";
  return is_library(named)
             ? "a scene file may name a library by its name alone, or by the full path of a file that others "
               "cannot write"
             : "a scene file may name an address of this computer, or the full path of a socket";
}

}  // namespace

std::vector<NamedPlace> device_places(Scene& scene) {
  std::vector<NamedPlace> out;
  for (auto& [name, tool] : tools_of(scene)) {
    if (!tool->path.device) continue;
    DeviceSettings& device = *tool->path.device;
    if (!device.library.empty()) out.push_back({name + ".path.device.library", &device.library});
    if (!device.address.empty()) out.push_back({name + ".path.device.address", &device.address});
  }
  return out;
}

std::vector<NamedPlace> scene_files(Scene& scene) {
  std::vector<NamedPlace> out;
  if (!scene.object.mesh.empty()) out.push_back({"object.mesh", &scene.object.mesh});
  for (auto& [name, tool] : tools_of(scene)) {
    if (!tool->mesh.empty()) out.push_back({name + ".mesh", &tool->mesh});
    if (auto& recording = tool->path.recording; recording && !recording->empty())
      out.push_back({name + ".path.recording", &*recording});
  }
  return out;
}

void require_named_here(const Scene& scene, const Scene& own, SceneDoor door, const std::string& from) {
  Scene asked = scene, allowed = own;
  const std::vector<NamedPlace> known = device_places(allowed);
  for (const NamedPlace& named : device_places(asked)) {
    const bool is_own = std::ranges::any_of(
        known, [&](const NamedPlace& k) { return *k.place == *named.place && is_library(k) == is_library(named); });
    if (!is_own && !may_name(named, door))
      throw InputError(text(visible(from), ": ", named.key, " is \"", visible(*named.place),
                            "\": ", rule_of(named, door), "; --set ", named.key, "=... on the command line names any"));
  }
}

void require_beside(const Scene& scene, const Scene& own, const std::string& from) {
  Scene asked = scene, allowed = own;
  const std::vector<NamedPlace> known = scene_files(allowed);
  for (const NamedPlace& named : scene_files(asked)) {
    const bool is_own =
        std::ranges::any_of(known, [&](const NamedPlace& k) { return k.key == named.key && *k.place == *named.place; });
    if (!is_own && (named.place->find('/') != std::string::npos || *named.place == ".."))
      throw InputError(text(visible(from), ": ", named.key, " is \"", visible(*named.place),
                            "\": a scene of others names files that came with it, without a folder"));
  }
}

}  // namespace kt
