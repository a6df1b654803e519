// kilotouch replay SESSION: a recorded run again, bit for bit.
#include <iostream>

#include "apps/commands.hpp"
#include "apps/outputs/run_outputs.hpp"
#include "apps/outputs/run_summary.hpp"
#include "apps/outputs/session_file.hpp"
#include "apps/run_session.hpp"
#include "apps/words.hpp"
#include "io/files/shell_words.hpp"

namespace kt {
namespace {

void replay(std::string file, RunSettings settings, int& exit_code) {
  file = session_file(file);
  SavedSession session = read_session(file);
  const Scene& scene = session.scene;
  const std::string& hash = session.hash;
  settings.files = std::move(session.files);
  settings.session = session.options;
  settings.piped = Piped::lines;
  settings.input = file;
  settings.reproduce = shell_words({"kilotouch", "replay", file});
  const RunOutcome outcome = run_scene(scene, settings);
  if (outcome.result.stopped) return;
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
  auto out = std::make_shared<std::string>(), json = std::make_shared<std::string>();
  auto details = std::make_shared<bool>(false);
  command->add_option("SESSION", *file, "session.json of a run, or the run's folder")->required();
  add_json_option(*command, *json, "the summary");
  command->add_flag("--details", *details, "print every figure, not the first screen alone");
  command->add_option("--out", *out, "folder for the results of the replay; none are written without it");
  auto force = std::make_shared<bool>(false);
  command->add_flag("--force", *force, "replace another scene's results in the folder --out");
  command->footer("Example:\n  kilotouch run scenes/slab_drag.json --out out/slab && kilotouch replay out/slab");
  command->callback([file, out, force, json, details, &exit_code] {
    RunSettings settings;
    settings.out = *out;
    settings.force = *force;
    settings.json_file = *json;
    settings.details = *details;
    replay(*file, std::move(settings), exit_code);
  });
}

}  // namespace kt
