// kilotouch replay SESSION: a recorded run again, bit for bit.
#include <filesystem>
#include <fstream>
#include <iostream>

#include "apps/commands.hpp"
#include "apps/run_outputs.hpp"
#include "apps/run_session.hpp"
#include "core/error.hpp"

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

void replay(std::string file, const std::string& out, int& exit_code) {
  if (std::filesystem::is_directory(file)) file += "/session.json";
  const nlohmann::json json = load_session(file);
  Scene scene;
  RunSettings settings;
  std::string hash;
  try {
    scene = parse_scene(json["scene"].dump(), {}, file);
    const auto recording = std::filesystem::path(file).parent_path() / json["recording"].get<std::string>();
    scene.tool.path = {std::nullopt, std::nullopt, recording.string(), std::nullopt};
    settings.session.max_speed = json["max_speed"].get<double>();
    if (scene.second_tool) {
      const auto& second = json.at("second_tool");
      const auto path = std::filesystem::path(file).parent_path() / second.at("recording").get<std::string>();
      scene.second_tool->path = {std::nullopt, std::nullopt, path.string(), std::nullopt};
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
  exit_code = same ? run_exit_code(outcome) : 1;
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
