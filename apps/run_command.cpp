// kilotouch run SCENE.json
#include "apps/commands.hpp"
#include "apps/run_session.hpp"
#include "apps/words.hpp"
#include "haptics/study/reference.hpp"
#include "io/files/shell_words.hpp"

namespace kt {
namespace {

struct RunArguments {
  std::string scene;
  std::vector<std::string> set;
  RunSettings settings;
  bool no_report = false, is_static = false, as_real_time = false;
};

}  // namespace

void add_run_command(CLI::App& app, int& exit_code) {
  auto* command = app.add_subcommand("run", "run a scene: force, trace, summary, report");
  auto a = std::make_shared<RunArguments>();
  a->settings.out = "out";
  command->add_option("SCENE", a->scene, "scene file (docs/scene.md)")->required();
  command->add_option("--set", a->set, "change a setting of the scene, KEY=VALUE; may be repeated")
      ->allow_extra_args(false);
  command->add_flag("--static", a->is_static,
                    "the body in equilibrium at every step: --set global.integrator=quasistatic");
  command->add_flag("--as-real-time", a->as_real_time,
                    "each refresh as late as it takes on this machine, what a person gets: --set link.type=lockstep "
                    "--set link.charge_refreshes=measured");
  auto* out = command->add_option("--out", a->settings.out, "folder for the results")->capture_default_str();
  add_json_option(*command, a->settings.json_file, "the summary");
  command->add_flag("--force", a->settings.force, "replace another scene's results in the folder --out");
  auto* reference = command->add_flag("--reference", a->settings.reference.compute,
                                      "also run the full model in fine steps along the same path, and compare");
  command->add_option("--reference-rate", a->settings.reference.rate_hz, "of those steps [Hz]")
      ->capture_default_str()
      ->needs(reference);
  command
      ->add_option("--reference-file", a->settings.reference.file,
                   "compare with the reference.csv of an earlier run on the same body and path")
      ->excludes(reference);
  command->add_option(
      "--truth", a->settings.reference.truth,
      "also compare with reference.csv or trace.csv of a better run along the same tool path, as on a finer mesh");
  command->add_flag("--states", a->settings.states, "write the body's states for ParaView (states.pvd)");
  command->add_flag("--details", a->settings.details, "print every figure, not the first screen alone");
  command->add_flag("--no-report", a->no_report, "numbers only: no pictures, no report.html");
  command->add_option("--figures", a->settings.figures, "force and mesh also as vectors: svg or pdf")
      ->check(CLI::IsMember({"svg", "pdf"}));
  command->footer("Example:\n  kilotouch run scenes/slab_drag.json --set contact.mu=0.8 --out out/slab");
  command->callback([a, out, &exit_code] {
    a->settings.report = !a->no_report;
    a->settings.force = a->settings.force || out->empty();  // the default folder holds the last run, whatever it was
    if (a->is_static) a->set.push_back("global.integrator=quasistatic");
    if (a->as_real_time) {
      a->set.push_back("link.type=lockstep");
      a->set.push_back("link.charge_refreshes=measured");
    }
    a->settings.input = a->scene;
    std::vector<std::string> words{"kilotouch", "run", a->scene};
    for (const std::string& set : a->set) words.insert(words.end(), {"--set", set});
    a->settings.reproduce = shell_words(words);
    const Scene scene = load_scene(a->scene, a->set);
    const bool has_reference = a->settings.reference.compute || !a->settings.reference.file.empty();
    const RunOutcome outcome = run_scene(has_reference ? with_own_cells(scene) : scene, a->settings);
    exit_code = run_exit_code(outcome);
  });
}

}  // namespace kt
