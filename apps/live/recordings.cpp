#if KT_WITH_BEAST
#include "apps/live/recordings.hpp"

#include <sys/stat.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>

#include "apps/console/allocation_counter.hpp"
#include "apps/console/stop_signals.hpp"
#include "apps/outputs/run_outputs.hpp"
#include "apps/outputs/run_summary.hpp"
#include "apps/outputs/session_file.hpp"
#include "core/base/error.hpp"
#include "core/base/temporary_folder.hpp"
#include "io/files/json_file.hpp"
#include "io/files/output_file.hpp"

namespace kt {
namespace {

namespace fs = std::filesystem;

/// The first of DIR/001, DIR/002, ... that is not there: made, so that it is nobody else's.
std::string next_folder(const std::string& dir) {
  make_folder(dir);
  for (int i = 1; i < 100000; ++i) {
    char name[16];
    std::snprintf(name, sizeof name, "%03d", i);
    const std::string out = (fs::path(dir) / name).string();
    if (::mkdir(out.c_str(), 0777) == 0) return out;
    if (errno != EEXIST) throw InputError(text(out, ": cannot make the folder: ", std::strerror(errno)));
  }
  throw InputError(text("--record ", dir, ": is full"));
}

/// A mesh that was dropped into the page lies in a temporary folder: the scene names the one that the session holds.
void name_held_mesh(const std::string& folder, const Session& session) {
  std::error_code none;
  if (fs::relative(session.scene().object.mesh, temporary_folder(), none).string().starts_with("..")) return;
  for (const HeldFile& held : held_files(session)) {
    if (held.key != "object.mesh") continue;
    auto scene = read_json_file(folder + "/scene.json");
    scene["object"]["mesh"] = text(kHeldFiles, '/', held.name);
    return write_file_whole(folder + "/scene.json", json_text(scene, 2) + "\n");
  }
}

class RecordingFolder {
 public:
  RecordingFolder(std::string dir, std::string command) : dir_(std::move(dir)), command_(std::move(command)) {}

  /// Before a recording begins: throws InputError where it could not be written. A stop waits for it from then on.
  void require() {
    require_writable_folder(dir_, "--record " + dir_);
    const std::scoped_lock lock(guard_);
    if (!begun_) begun_.emplace();
  }

  /// @returns the folder that was written
  std::string save(const Session& session, const SessionResult& result, const BodyFilm& film) {
    const SavingResults until_saved;
    {
      const std::scoped_lock lock(guard_);
      begun_.reset();
    }
    const std::string folder = next_folder(dir_);
    auto summary = make_summary(session, result);
    summary["command"] = command_;
    write_run(folder, session, result, summary, &film);
    name_held_mesh(folder, session);
    return folder;
  }

 private:
  std::string dir_, command_;
  std::mutex guard_;
  std::optional<SavingResults> begun_;
};

}  // namespace

ViewOptions recorded_page(const PageArguments& page, const std::string& device, const std::string& folder,
                          const std::string& command) {
  check_page(page);
  ViewOptions out;
  out.server = {page.listen, static_cast<unsigned short>(page.port), page.token};
  out.by_pointer = device == "pointer";
  const auto recordings = std::make_shared<RecordingFolder>(folder, command);
  out.before_recording = [recordings] { recordings->require(); };
  out.save = [recordings](const Session& s, const SessionResult& r, const BodyFilm& f) {
    return recordings->save(s, r, f);
  };
  out.count_allocations = thread_allocations() >= 0 ? std::function<long long()>(thread_allocations) : nullptr;
  out.stop = &stop_requested();
  out.ready = [page](const std::string& url) { tell_of_page(page, url); };
  return out;
}

}  // namespace kt
#endif
