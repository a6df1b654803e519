// kilotouch view SCENE|MESH|SESSION: see the body, take the tool with the mouse, record.
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "apps/commands.hpp"
#include "core/base/error.hpp"
#include "haptics/device/haptic_device.hpp"

#if KT_WITH_BEAST
#include "apps/allocation_counter.hpp"
#include "apps/live_scene.hpp"
#include "apps/mesh_scene.hpp"
#include "apps/run_outputs.hpp"
#include "apps/session_file.hpp"
#include "apps/stop_signals.hpp"
#include "apps/words.hpp"
#include "io/files/child_process.hpp"
#include "io/files/json_file.hpp"
#include "io/files/output_file.hpp"
#include "io/mesh/mesh_io.hpp"
#include "view/view.hpp"
#endif

namespace kt {
namespace {

struct ViewArguments {
  std::string what, listen = "127.0.0.1", token, device = "pointer", record = "recordings";
  int port = 8080;
  std::vector<std::string> set;
  bool open = false;
};

#if KT_WITH_BEAST

namespace fs = std::filesystem;

/// Scenes beside the one that is shown, or those of the project.
std::vector<fs::path> scene_files(const std::string& shown) {
  std::vector<fs::path> out;
  const fs::path own = fs::path(shown).extension() == ".json" ? fs::absolute(shown).parent_path() : fs::path();
  for (const fs::path& folder : {own, fs::path(KT_SCENES_SOURCE)}) {
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(folder, none))
      if (entry.path().extension() == ".json") out.push_back(entry.path());
    if (!out.empty()) break;
  }
  std::ranges::sort(out);
  return out;
}

bool is_session(const std::string& what) {
  if (fs::is_directory(what)) return true;
  if (fs::path(what).extension() != ".json") return false;
  try {
    const auto json = read_json_file(what);
    return json.is_object() && json.contains("refreshes") && json.contains("recording");
  } catch (const InputError&) {
    return false;  // a scene with comments, or wrong: load_scene tells
  }
}

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
  if (fs::relative(mesh, fs::temp_directory_path(), none).string().starts_with("..")) return;
  const fs::path kept = fs::absolute(folder) / fs::path(mesh).filename();
  fs::copy_file(mesh, kept);
  for (const char* file : {"/session.json", "/scene.json"}) {
    auto json = read_json_file(folder + file);
    auto& scene = json.contains("scene") ? json["scene"] : json;
    scene["object"]["mesh"] = kept.string();
    write_file_whole(folder + file, json_text(json, 2) + "\n");
  }
}

std::string save(const std::string& dir, const Session& session, const SessionResult& result, const BodyFilm& film) {
  const SavingResults until_saved;
  const std::string folder = next_folder(dir);
  make_folder(folder);
  auto summary = make_summary(session, result);
  summary["command"] = "kilotouch view";
  write_run(folder, session, result, summary, &film);
  keep_mesh(folder, session.scene().object.mesh);
  return folder;
}

/// What `kilotouch mesh info` finds, in a process of its own.
std::string examine(const std::string& file) {
  const PrivateFolder folder;
  const std::string json = folder / "findings.json";
  const ChildLimits limits{.seconds = 20, .memory_bytes = std::size_t{8} << 30, .stop = &stop_requested()};
  const ChildResult run = run_program({fs::read_symlink("/proc/self/exe").string(), "mesh", "info", file, "--json",
                                       json, "--no-intersections", "--quiet"},
                                      folder, limits);
  if (!fs::exists(json)) {
    const bool said = run.exit_code == 2 && run.signal == 0 && !run.timed_out;  // one line, of our own
    throw InputError(said ? run.output : run.trouble(limits));
  }
  const auto report = read_json_file(json).at("report");
  nlohmann::ordered_json out;
  for (const char* key : {"nodes", "triangles", "tetrahedra", "components", "likely_unit"}) out[key] = report.at(key);
  for (const auto& [name, places] : report.at("defects").items()) out["defects"][name] = places.size();
  return json_text(out);
}

void check(const ViewArguments& a) {
  if (a.port < 0 || a.port > 65535) throw InputError(text("--port is ", a.port, ", must be 0 .. 65535"));
  check_live_device(a.device, {"pointer", "scene"});
  const auto is_plain = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_'; };
  if (!std::ranges::all_of(a.token, is_plain))
    throw InputError("--token: only letters, digits, - and _, as it is part of an address");
}

void view(const ViewArguments& a) {
  check(a);
  const std::vector<fs::path> files = scene_files(a.what);
  ViewOptions options;
  options.server = {a.listen, static_cast<unsigned short>(a.port), a.token};
  options.by_pointer = a.device == "pointer";
  options.save = [dir = a.record](const Session& s, const SessionResult& r, const BodyFilm& f) {
    return save(dir, s, r, f);
  };
  for (const fs::path& file : files) options.scenes.push_back(file.stem().string());
  options.load_scene = [files, device = a.device](const std::string& name) {
    const auto file = std::ranges::find_if(files, [&](const fs::path& f) { return f.stem() == name; });
    return with_live_device(load_scene(file->string()), device);
  };
  options.scene_of_mesh = [device = a.device](const std::string& file) {
    return with_live_device(scene_of_mesh(file, {}), device);
  };
  options.examine = examine;
  options.count_allocations = thread_allocations() >= 0 ? std::function<long long()>(thread_allocations) : nullptr;
  options.stop = &stop_requested();
  options.ready = [open = a.open](const std::string& url) {
    std::cout << "open " << url << " in a browser; Ctrl-C ends it" << std::endl;
    if (open && std::system(("xdg-open '" + url + "' >/dev/null 2>&1 &").c_str()) != 0)
      std::cerr << "kilotouch: --open: no browser could be started\n";
  };
  if (is_session(a.what)) {
    if (!a.set.empty()) throw InputError("--set: a session is played as it was recorded");
    SavedSession saved = read_session(session_file(a.what));
    std::cout << "running the session again ..." << std::endl;
    saved.options.stop = &stop_requested();
    return view_session(saved.scene, saved.options, options);
  }
  const std::vector<std::string> meshes = readable_mesh_extensions();
  const bool is_mesh = std::ranges::find(meshes, mesh_extension(a.what)) != meshes.end();
  view_scene(with_live_device(is_mesh ? scene_of_mesh(a.what, a.set) : load_scene(a.what, a.set), a.device), options);
}

#else

void view(const ViewArguments&) {
  throw InputError("view: this program was built without it; configure with -DKT_WITH_BEAST=ON");
}

#endif

}  // namespace

void add_view_command(CLI::App& app, int&) {
  auto* command = app.add_subcommand("view", "see the body in a browser, take the tool with the mouse, record");
  auto a = std::make_shared<ViewArguments>();
  command->add_option("WHAT", a->what, "scene file, mesh, or a run's folder (session.json) to play")->required();
  command->add_option("--set", a->set, "change a setting of the scene, KEY=VALUE; may be repeated")
      ->allow_extra_args(false);
  command->add_option("--port", a->port, "of the page; 0: any that is free")->capture_default_str();
  command->add_option("--listen", a->listen, "address; others than this computer's own need --token")
      ->capture_default_str();
  command->add_option("--token", a->token, "that the page's address must have");
  command
      ->add_option("--device", a->device,
                   "what moves the tool: pointer (the page's), scene (the scene's path), or a haptic device: haply ...")
      ->capture_default_str();
  command->add_option("--record", a->record, "folder for recordings")->capture_default_str();
  command->add_flag("--open", a->open, "open the page in this computer's browser");
  command->footer("Example:\n  kilotouch view scenes/organ_drag.json --open");
  command->callback([a] { view(*a); });
}

}  // namespace kt
