#include "apps/recordings.hpp"

#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/outputs/run_outputs.hpp"
#include "apps/outputs/run_summary.hpp"
#include "apps/stop_signals.hpp"
#include "core/base/error.hpp"
#include "core/base/temporary_folder.hpp"
#include "io/files/json_file.hpp"
#include "io/files/output_file.hpp"

namespace kt {
namespace {

namespace fs = std::filesystem;

/// The first of DIR/001, DIR/002, ... that is not there.
std::string next_folder(const std::string& dir) {
  for (int i = 1; i < 100000; ++i) {
    char name[16];
    std::snprintf(name, sizeof name, "%03d", i);
    const fs::path out = fs::path(dir) / name;
    if (!fs::exists(out)) return out.string();
  }
  throw InputError(text("--record ", dir, ": is full"));
}

/// A mesh that was dropped into the page lies in a temporary folder: the recording keeps it.
void keep_mesh(const std::string& folder, const std::string& mesh) {
  std::error_code none;
  if (fs::relative(mesh, temporary_folder(), none).string().starts_with("..")) return;
  const fs::path kept = fs::absolute(folder) / fs::path(mesh).filename();
  fs::copy_file(mesh, kept);
  for (const char* file : {"/session.json", "/scene.json"}) {
    auto json = read_json_file(folder + file);
    auto& scene = json.contains("scene") ? json["scene"] : json;
    scene["object"]["mesh"] = kept.string();
    write_file_whole(folder + file, json_text(json, 2) + "\n");
  }
}

}  // namespace

std::string save_recording(const std::string& dir, const std::string& command, const Session& session,
                           const SessionResult& result, const BodyFilm& film) {
  const SavingResults until_saved;
  const std::string folder = next_folder(dir);
  make_folder(folder);
  auto summary = make_summary(session, result);
  summary["command"] = command;
  write_run(folder, session, result, summary, &film);
  keep_mesh(folder, session.scene().object.mesh);
  return folder;
}

}  // namespace kt
