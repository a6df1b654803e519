// kilotouch replay SESSION: a recorded run again, bit for bit.
#include <filesystem>
#include <fstream>
#include <iostream>

#include "apps/commands.hpp"
#include "apps/run_outputs.hpp"
#include "apps/run_session.hpp"
#include "core/error.hpp"
#include "haptics/device/recording.hpp"

namespace kt {
namespace {

nlohmann::json load_session(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw InputError(text(file, ": cannot read the session (a run leaves it as OUT/session.json)"));
  try {
    auto json = nlohmann::json::parse(in);
    for (const char* key : {"scene", "recording", "refreshes", "max_speed", "hash"})
      if (!json.contains(key)) throw InputError(text(file, ": not a session file: \"", key, "\" is missing"));
    return json;
  } catch (const nlohmann::json::exception& e) {
    throw InputError(text(file, ": not a session file: ", e.what()));
  }
}

/// The scene keeps its own path, so that figures and outputs are those of the run; the tool goes the way that it went.
void add_path(const Scene& scene, SceneTool& tool, const std::string& recording, SessionOptions& out) {
  out.tool_paths.push_back(read_recording(recording, 1 / scene.local.rate_hz).path);
  if (tool.path.recording) tool.path.recording = recording;  // the one it was made from may be gone
}

void replay(std::string file, const std::string& out, int& exit_code) {
  if (std::filesystem::is_directory(file)) file += "/session.json";
  const nlohmann::json json = load_session(file);
  Scene scene;
  RunSettings settings;
  std::string hash;
  try {
    scene = parse_scene(json["scene"].dump(), {}, file);
    const auto recorded = [&](const nlohmann::json& of) {
      return (std::filesystem::path(file).parent_path() / of.at("recording").get<std::string>()).string();
    };
    add_path(scene, scene.tool, recorded(json), settings.session);
    settings.session.max_speed = json["max_speed"].get<double>();
    if (scene.second_tool) {
      const auto& second = json.at("second_tool");
      add_path(scene, *scene.second_tool, recorded(second), settings.session);
      settings.session.second_max_speed = second.at("max_speed").get<double>();
    }
    for (const auto& r : json["refreshes"]) settings.session.refreshes.push_back({r.at(0), r.at(1), r.at(2)});
    hash = json["hash"].get<std::string>();
  } catch (const nlohmann::json::exception& e) {
    throw InputError(text(file, ": damaged session file: ", e.what()));
  }
  settings.out = out;
  settings.reproduce = "kilotouch replay " + file;
  const RunOutcome outcome = run_scene(scene, settings);
  const bool same = hash_text(outcome.result.hash) == hash;
  std::cout << (same ? "the replay equals the recorded run bit for bit: hash "
                     : "the replay DIFFERS from the recorded run: recorded hash ")
            << hash << '\n';
  exit_code = same ? 0 : 1;
}

}  // namespace

void add_replay_command(CLI::App& app, int& exit_code) {
  auto* command = app.add_subcommand("replay", "run a recorded session again and compare its hash");
  auto file = std::make_shared<std::string>();
  auto out = std::make_shared<std::string>();
  command->add_option("SESSION", *file, "session.json of a run, or the run's folder")->required();
  command->add_option("--out", *out, "folder for the results of the replay; none are written without it");
  command->footer("Example:\n  kilotouch run scenes/slab_drag.json --out out/slab && kilotouch replay out/slab");
  command->callback([file, out, &exit_code] { replay(*file, *out, exit_code); });
}

}  // namespace kt
