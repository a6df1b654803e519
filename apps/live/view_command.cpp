// kilotouch view SCENE|MESH|SESSION: see the body, take the tool with the mouse, record.
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <nlohmann/json.hpp>

#include "apps/console/commands.hpp"
#include "apps/live/page_options.hpp"
#include "core/base/error.hpp"
#include "core/base/visible_text.hpp"
#include "haptics/device/haptic_device.hpp"

#if KT_WITH_BEAST
#include "apps/console/data_files.hpp"
#include "apps/console/words.hpp"
#include "apps/live/live_scene.hpp"
#include "apps/live/recordings.hpp"
#include "apps/outputs/session_file.hpp"
#include "apps/run/given_file.hpp"
#include "io/files/child_process.hpp"
#include "io/files/json_file.hpp"
#include "io/files/output_file.hpp"
#endif

namespace kt {
namespace {

struct ViewArguments {
  std::string what, device = "pointer", id, record = "recordings";
  PageArguments page;
  std::vector<std::string> set;
  bool names_record = false;
};

#if KT_WITH_BEAST

namespace fs = std::filesystem;

/// Scenes beside the one that is shown, or those of the project.
std::vector<fs::path> scene_files(const std::string& shown) {
  std::vector<fs::path> out;
  const fs::path own = fs::path(shown).extension() == ".json" ? fs::absolute(shown).parent_path() : fs::path();
  for (const fs::path& folder : {own, find_data("scenes")}) {
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(folder, none))
      if (entry.path().extension() == ".json") out.push_back(entry.path());
    if (!out.empty()) break;
  }
  std::ranges::sort(out);
  return out;
}

/// A name may be any bytes; a page takes UTF-8.
std::string shown_name(const fs::path& scene) { return escape_bytes(scene.stem().string()); }

/// What a program of ours said last, without its name.
std::string last_words(std::string said) {
  while (said.ends_with('\n')) said.pop_back();
  const std::string line = said.substr(said.rfind('\n') + 1), name = "kilotouch: ";
  return line.starts_with(name) ? line.substr(name.size()) : line;
}

/// Why it ended: the line that it said, where that was one for people.
std::string why_ended(const ChildResult& run, const ChildLimits& limits) {
  const bool said = run.exit_code == 2 && run.signal == 0 && !run.timed_out;
  return said ? last_words(run.output) : run.trouble(limits);
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
    throw InputError(why_ended(run, limits));
  }
  const auto report = read_json_file(json).at("report");
  nlohmann::ordered_json out;
  for (const char* key : {"nodes", "triangles", "tetrahedra", "components", "likely_unit"}) out[key] = report.at(key);
  std::size_t count = 0;
  for (const auto& [name, places] : report.at("defects").items()) {
    out["defects"][name] = places.size();
    count += places.size();
  }
  out["needs_repair"] = count > 0 && report.at("tetrahedra") == 0;
  return json_text(out);
}

/// What `kilotouch mesh repair` makes of it: as little as leaves no hole.
std::string repair_mesh(const std::string& file) {
  const PrivateFolder folder;
  const fs::path given(file);
  const std::string out = (given.parent_path() / ("repaired " + given.stem().string() + ".off")).string();
  const std::string json = folder / "repair.json";
  const ChildLimits limits{.seconds = 120, .memory_bytes = std::size_t{8} << 30, .stop = &stop_requested()};
  const std::string self = fs::read_symlink("/proc/self/exe").string();
  ChildResult run;
  for (const char* more : {"--weld=0", "--fill-holes=100", "--wrap"}) {
    run = run_program({self, "mesh", "repair", file, "-o", out, "--json", json, "--no-intersections", "--quiet", more},
                      folder, limits);
    if (run.good() && read_json_file(json).at("report").at("closed").get<bool>()) return out;
  }
  throw InputError(run.good() ? "the surface has holes that repair does not close" : why_ended(run, limits));
}

/// An organ that needs no program to fill it with tetrahedra.
std::string own_scene() {
  const fs::path file = find_data("scenes/organ_solid.json");
  if (file.empty()) throw InputError("view: no scene is named, and scenes/organ_solid.json is not beside the program");
  return file.string();
}

void view(ViewArguments a) {
  ViewOptions options = recorded_page(a.page, a.device, a.record, "kilotouch view");
  if (a.what.empty()) a.what = own_scene();
  if (a.names_record) require_writable_folder(a.record, "--record " + a.record);  // else when Record is pressed
  check_live_device(a.device, {"scene"});
  const std::vector<fs::path> files = scene_files(a.what);
  options.folder = fs::absolute(a.what).parent_path().string();
  for (const fs::path& file : files) options.scenes.push_back(shown_name(file));
  options.load_scene = [files, device = a.device, id = a.id](const std::string& name) {
    const auto file = std::ranges::find_if(files, [&](const fs::path& f) { return shown_name(f) == name; });
    return with_live_device(load_scene(file->string()), device, id);
  };
  options.scene_of_mesh = [device = a.device, id = a.id](const std::string& file) {
    return with_live_device(scene_of_mesh(file, {}), device, id);
  };
  options.examine = examine;
  options.repair = repair_mesh;
  if (kind_of_file(a.what) == Given::session) {
    if (!a.set.empty()) throw InputError("--set: a session is played as it was recorded");
    SavedSession saved = read_session(session_file(a.what));
    std::cout << "running the session again ..." << std::endl;
    saved.options.stop = &stop_requested();
    return view_session(saved.scene, std::move(saved.files), saved.options, options);
  }
  view_scene(with_live_device(scene_of_file(a.what, a.set), a.device, a.id), options);
}

#else

void view(ViewArguments) {
  throw InputError("view: this program was built without it; configure with -DKT_WITH_BEAST=ON");
}

#endif

}  // namespace

void add_view_command(CLI::App& app, int&) {
  auto* command = app.add_subcommand("view", "see the body in a browser, take the tool with the mouse, record");
  auto a = std::make_shared<ViewArguments>();
  command->add_option("WHAT", a->what,
                      "scene file, mesh, or a run's folder (session.json) to play. Without it an organ");
  command->add_option("--set", a->set, "change a setting of the scene, KEY=VALUE, as often as needed")
      ->allow_extra_args(false);
  add_page_options(*command, a->page);
  command
      ->add_option(
          "--device", a->device,
          "source of the tool's motion, pointer (of the page), scene (its path) or a haptic device (haply ...)")
      ->capture_default_str();
  command->add_option("--id", a->id, "of a haptic device, where there are several (kilotouch device list)");
  auto* record = command->add_option("--record", a->record, "folder for recordings")->capture_default_str();
  command->footer("Example:\n  kilotouch view scenes/organ_drag.json --open");
  command->callback([a, record] {
    a->names_record = !record->empty();
    view(*a);
  });
}

}  // namespace kt
