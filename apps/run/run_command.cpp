// kilotouch run SCENE|MESH|SESSION, and its former words: drag, replay.
#include <iostream>

#include "apps/console/commands.hpp"
#include "apps/console/words.hpp"
#include "apps/outputs/run_summary.hpp"
#include "apps/outputs/session_file.hpp"
#include "apps/run/given_file.hpp"
#include "apps/run/run_session.hpp"
#include "io/files/shell_words.hpp"

namespace kt {
namespace {

struct RunArguments {
  std::string file;
  std::vector<std::string> set;
  RunSettings settings;
  bool no_report = false, is_static = false, as_real_time = false;
};

/// A recorded run again, bit for bit.
int replay(const std::string& file_or_folder, RunSettings settings) {
  const std::string file = session_file(file_or_folder);
  SavedSession session = read_session(file);
  settings.files = std::move(session.files);
  settings.session = session.options;
  settings.piped = Piped::lines;
  settings.input = file;
  settings.reproduce = shell_words({"kilotouch", "run", file});
  const RunOutcome outcome = run_scene(session.scene, settings);
  if (outcome.result.stopped) return 0;
  const bool same = hash_text(outcome.result.hash) == session.hash;
  std::cout << (same ? "the replay equals the recorded run bit for bit: hash "
                     : "the replay DIFFERS from the recorded run: recorded hash ")
            << session.hash << '\n';
  return same ? run_exit_code(outcome) : 1;
}

int run(RunArguments& a) {
  if (a.is_static) a.set.push_back("global.integrator=quasistatic");
  if (a.as_real_time) a.set.insert(a.set.end(), {"link.type=lockstep", "link.charge_refreshes=measured"});
  if (kind_of_file(a.file) == Given::session) {
    if (!a.set.empty()) throw InputError("--set: a session is run again as it was recorded; change its scene.json");
    if (a.settings.comparison && a.settings.comparison->is_asked())
      throw InputError("--reference: a session is run again as it was recorded; run its scene.json");
    return replay(a.file, std::move(a.settings));
  }
  a.settings.input = a.file;
  std::vector<std::string> words{"kilotouch", "run", a.file};
  for (const std::string& set : a.set) words.insert(words.end(), {"--set", set});
  a.settings.reproduce = shell_words(words);
  return run_exit_code(run_scene(scene_of_file(a.file, a.set), a.settings));
}

CLI::App* add_run(CLI::App& app, const std::string& word, const std::string& purpose, int& exit_code) {
  auto* command = app.add_subcommand(word, purpose);
  auto a = std::make_shared<RunArguments>();
  a->settings.out = "out";
  command
      ->add_option(
          "WHAT", a->file,
          "scene file (docs/scene.md), surface mesh (OBJ OFF PLY STL), solid mesh (node/ele MSH VTU), or the folder of "
          "a run (session.json), to repeat it")
      ->required();
  command->add_option("--set", a->set, "change a setting of the scene, KEY=VALUE, as often as needed")
      ->allow_extra_args(false);
  command->add_flag("--static", a->is_static,
                    "the body in equilibrium at every step (--set global.integrator=quasistatic)");
  command->add_flag("--as-real-time", a->as_real_time,
                    "delay each local model by the time of its refresh on this machine (--set link.type=lockstep "
                    "--set link.charge_refreshes=measured)");
  auto* out = command->add_option("--out", a->settings.out, "folder for the results")->capture_default_str();
  add_json_option(*command, a->settings.json_file, "the summary");
  command->add_flag("--force", a->settings.force, "replace another scene's results in the folder --out");
#if KT_WITH_LAB
  a->settings.comparison = add_reference_options(*command);
#endif
  command->add_flag("--states", a->settings.states, "write the body's states for ParaView (states.pvd)");
  command->add_flag("--details", a->settings.details, "print every figure, not the first screen alone");
  command->add_flag("--no-report", a->no_report, "numbers only, without pictures and report.html");
  command->add_option("--figures", a->settings.figures, "format of additional pictures of force and mesh")
      ->check(CLI::IsMember({"svg", "pdf"}));
  command->footer(
      "A mesh is scaled to 0.1 m (--set object.size=...), clamped in its lowest fifth, pressed and dragged over.\n"
      "A surface is put into a lattice of cubes. --set object.body=mesh repairs and fills it instead.\n"
      "Examples:\n  kilotouch run scenes/slab_drag.json --set contact.mu=0.8 --out out/slab\n"
      "  kilotouch run meshes/organ.off --out out/organ\n  kilotouch run out/slab");
  command->callback([a, out, &exit_code] {
    a->settings.report = !a->no_report;
    a->settings.force = a->settings.force || out->empty();  // the default folder holds the last run, whatever it was
    exit_code = run(*a);
  });
  return command;
}

}  // namespace

void add_run_command(CLI::App& app, int& exit_code) {
  add_run(app, "run", "run a scene, a mesh or a recorded session, and write force, trace, summary and report",
          exit_code);
  add_run(app, "drag", "the same as kilotouch run, which takes meshes, too", exit_code)->group("");
}

void add_replay_command(CLI::App& app, int& exit_code) {
  auto* command = app.add_subcommand("replay", "repeat a recorded session and compare its hash, without results");
  auto file = std::make_shared<std::string>();
  auto settings = std::make_shared<RunSettings>();
  command->add_option("SESSION", *file, "session.json of a run, or the run's folder")->required();
  add_json_option(*command, settings->json_file, "the summary");
  command->add_flag("--details", settings->details, "print every figure, not the first screen alone");
  command->add_option("--out", settings->out, "folder for the results of the replay, by default none");
  command->add_flag("--force", settings->force, "replace another scene's results in the folder --out");
  command->footer("Example:\n  kilotouch run scenes/slab_drag.json --out out/slab && kilotouch replay out/slab");
  command->callback([file, settings, &exit_code] { exit_code = replay(*file, *settings); });
}

}  // namespace kt
