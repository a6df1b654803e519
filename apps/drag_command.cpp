// kilotouch drag MESH: the main job with no scene file.
#include "apps/commands.hpp"
#include "apps/mesh_scene.hpp"
#include "apps/run_session.hpp"
#include "apps/words.hpp"
#include "io/files/shell_words.hpp"

namespace kt {
namespace {

struct DragArguments {
  std::string mesh;
  std::vector<std::string> set;
  RunSettings settings;
  bool no_report = false;
};

}  // namespace

void add_drag_command(CLI::App& app, int& exit_code) {
  auto* command = app.add_subcommand("drag", "press and drag a tool over a mesh, with no scene file");
  auto a = std::make_shared<DragArguments>();
  a->settings.out = "out";
  command->add_option("MESH", a->mesh, "surface (OBJ OFF PLY STL) or solid (node/ele MSH VTU)")->required();
  command->add_option("--set", a->set, "change a setting, KEY=VALUE (docs/scene.md); may be repeated")
      ->allow_extra_args(false);
  auto* out = command->add_option("--out", a->settings.out, "folder for the results")->capture_default_str();
  add_json_option(*command, a->settings.json_file, "the summary");
  command->add_flag("--force", a->settings.force, "replace another mesh's results in the folder --out");
  command->add_flag("--states", a->settings.states, "write the body's states for ParaView (states.pvd)");
  command->add_flag("--details", a->settings.details, "print every figure, not the first screen alone");
  command->add_flag("--no-report", a->no_report, "numbers only: no pictures, no report.html");
  command->add_option("--figures", a->settings.figures, "force and mesh also as vectors: svg or pdf")
      ->check(CLI::IsMember({"svg", "pdf"}));
  command->footer(
      "The mesh is scaled to 0.1 m (--set object.size=...) and clamped in its lowest fifth.\n"
      "Example:\n  kilotouch drag meshes/organ.off --out out/organ --set contact.mu=0.3");
  command->callback([a, out, &exit_code] {
    a->settings.report = !a->no_report;
    a->settings.force = a->settings.force || out->empty();  // the default folder holds the last run, whatever it was
    a->settings.input = a->mesh;
    std::vector<std::string> words{"kilotouch", "drag", a->mesh};
    for (const std::string& set : a->set) words.insert(words.end(), {"--set", set});
    a->settings.reproduce = shell_words(words);
    const RunOutcome outcome = run_scene(scene_of_mesh(a->mesh, a->set), a->settings);
    exit_code = run_exit_code(outcome);
  });
}

}  // namespace kt
