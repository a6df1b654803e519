// kilotouch paper: the paper's three drag experiments (figures 3, 4, 5) and, beside them, the consistent law.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>

#include "apps/console/commands.hpp"
#include "apps/console/data_files.hpp"
#include "apps/console/report.hpp"
#include "apps/console/words.hpp"
#include "apps/run/run_session.hpp"
#include "core/base/error.hpp"
#include "haptics/session/metrics.hpp"
#include "io/files/json_file.hpp"
#include "io/files/output_file.hpp"
#include "io/files/output_folder.hpp"
#include "lab/commands/laboratory.hpp"
#include "lab/study/paper_claims.hpp"

namespace kt {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kRoundoff = 1e-12;  // |F_T| of pure sliding against F_N: one projection in double precision
constexpr double kCone = 1e-9;       // slack of F_T <= mu F_N

struct Experiment {
  std::string folder, law, metric, integrator;
  double mu;
  bool is_extended;  ///< this engine's method around the local model; else the paper's
};

// The paper as it is; its laws with what this engine adds to the method; the same drags with the consistent law.
const std::vector<Experiment> kExperiments = {
    {"slide", "paper_slide", "identity", "symplectic_euler", 0, false},
    {"stick", "paper_stick", "identity", "symplectic_euler", 0, false},
    {"stick_slip", "paper_stick_slip", "identity", "symplectic_euler", 1, false},
    {"slide_extended", "paper_slide", "identity", "symplectic_euler", 0, true},
    {"stick_extended", "paper_stick", "identity", "symplectic_euler", 0, true},
    {"stick_slip_extended", "paper_stick_slip", "identity", "symplectic_euler", 1, true},
    {"coulomb_slide", "coulomb", "implicit", "implicit_euler", 0, true},
    {"coulomb", "coulomb", "implicit", "implicit_euler", 1, true},
};

/// Sections II to IV: springs alone, one refresh every 100 ms and no other, linearized where the body is, the contact's
/// one-ring between walls, its state taken over and its force as it is.
void set_paper_method(Scene& scene) {
  scene.object.model.least_volume = 0;
  scene.global.rate_hz = 10;
  scene.global.early_refresh = false;
  scene.global.look_ahead = false;
  scene.local.reducer = "wall";
  scene.local.rings = 1;
  scene.local.catch_up = false;
  scene.local.blend_ms = 0;
}

/// A coarse block (5 mm triangles), pressed by a point and dragged across its top.
Scene paper_scene(const std::string& mesh, const Experiment& e, const std::vector<std::string>& set) {
  Scene scene = default_scene();
  scene.title = e.law + (e.is_extended ? ", extended" : ", as published");
  scene.duration = 1.0;
  scene.object.mesh = mesh;
  scene.object.model.young = 1000;
  scene.object.model.damping = {5, 1e-3};
  scene.tool.shape = "point";
  scene.tool.path.press_drag->depth = 0.002;
  scene.tool.path.press_drag->speed = 0.02;
  scene.contact.law = e.law;
  scene.contact.mu_static = scene.contact.mu_kinetic = e.mu;
  scene.contact.metric = e.metric;
  scene.global.integrator = "implicit_euler";
  scene.local.integrator = e.integrator;
  if (!e.is_extended) set_paper_method(scene);
  return parse_scene(to_json(scene), set, "paper");
}

Json claim(const std::string& what, double value, const std::string& bound, bool holds) {
  return {{"text", what}, {"value", value}, {"bound", bound}, {"holds", holds}};
}

Json check_claims(const std::vector<RunOutcome>& runs, double pressed) {
  const auto& slide = runs[0].summary["force"];
  const double sliding = slide["max_t"].get<double>() / slide["max_n"].get<double>();
  const double sticking = share_above_normal(runs[1].result.tools[0].frames, pressed);
  const double cone = measure_forces(runs[2].result.tools[0].frames, pressed, 1e-3).max_t_over_n;
  const double drop = largest_slip_drop(runs[2].result.tools[0].frames, pressed);
  return {claim("Pure sliding: largest F_T / largest F_N (the paper's figure 3: no tangential force)", sliding,
                "< 1e-12", sliding < kRoundoff && slide["max_n"].get<double>() > 0),
          claim("Pure sticking: share of the drag in which F_T exceeds F_N (figure 4: often)", sticking, "> 0.5",
                sticking > 0.5),
          claim("Stick-slip, mu = 1: largest F_T / (mu F_N) over all ticks (figure 5)", cone, "<= 1 + 1e-9",
                cone > 0 && cone <= 1 + kCone),
          claim("Stick-slip: transitions from sticking to sliding", stick_to_slip(runs[2].result.tools[0].frames),
                ">= 1", stick_to_slip(runs[2].result.tools[0].frames) >= 1),
          claim("Stick-slip: largest drop of F_T within 10 ms of a transition, share of F_T", drop, "> 0", drop > 0)};
}

Json table_row(const Experiment& e, const RunOutcome& run) {
  const auto& s = run.summary;
  const auto& local = s["settings"]["local"];
  return {{"method", e.is_extended ? "extended" : "paper"},
          {"law", e.law},
          {"metric", e.metric},
          {"mu", e.law == "paper_stick" ? Json() : Json(e.mu)},  // it has none
          {"integrator", e.integrator},
          {"reducer", s["local"]["name"]},
          {"refresh_hz", s["real_time"]["refresh_hz"]},
          {"blend_ms", local["blend_ms"]},
          {"mean_n", s["force"]["mean_n"]},
          {"mean_t", s["force"]["mean_t"]},
          {"buzz", s["force"]["buzz"]},
          {"crossing_jump", s["force"]["crossing_jump"]},
          {"refresh_jump", s["force"]["refresh_jump"]},
          {"penetration_max_m", s["penetration_max_m"]},
          {"step_us_p50", s["step_us"]["p50"]},
          {"hash", s["hash"]}};
}

void print(const Json& report) {
  std::cout << "Claims of the paper\n";
  for (const auto& c : report["claims"])
    std::printf("  %-5s %-92s %.6g (%s)\n", c["holds"].get<bool>() ? "holds" : "FAILS",
                c["text"].get<std::string>().c_str(), c["value"].get<double>(), c["bound"].get<std::string>().c_str());
  std::cout << "The same drag, law against law (buzz and jumps relative to the mean force)\n";
  std::printf("  %-9s %-17s %-9s %4s %-36s %5s %9s %9s %8s %14s %13s %8s\n", "method", "law", "metric", "mu",
              "local model", "Hz", "F_N [N]", "F_T [N]", "buzz", "crossing jump", "refresh jump", "step us");
  for (const auto& r : report["table"])
    std::printf("  %-9s %-17s %-9s %4s %-36s %5.0f %9.4f %9.4f %7.1f%% %13.1f%% %12.1f%% %8.2f\n",
                r["method"].get<std::string>().c_str(), r["law"].get<std::string>().c_str(),
                r["metric"].get<std::string>().c_str(), r["mu"].is_null() ? "-" : text(r["mu"].get<double>()).c_str(),
                r["reducer"].get<std::string>().c_str(), r["refresh_hz"].get<double>(), r["mean_n"].get<double>(),
                r["mean_t"].get<double>(), 100 * r["buzz"].get<double>(), 100 * r["crossing_jump"].get<double>(),
                100 * r["refresh_jump"].get<double>(), r["step_us_p50"].get<double>());
}

std::string find_block() {
  if (const auto file = find_data("meshes/block.msh"); !file.empty()) return file.string();
  throw InputError("paper: meshes/block.msh is missing; name a mesh with --mesh");
}

struct PaperArguments {
  std::string out = "out/paper", mesh, json_file;
  std::vector<std::string> set;
};

void run_paper(PaperArguments a, int& exit_code) {
  if (a.mesh.empty()) a.mesh = find_block();
  const OutputFolder folder(a.out, "--out " + a.out, {"paper.json", "paper.html"});
  std::vector<RunOutcome> runs;
  Json report{{"claims", Json::array()}, {"table", Json::array()}};
  for (const Experiment& e : kExperiments) {
    RunSettings settings;
    settings.out = a.out + "/" + e.folder;
    make_inner_folder(settings.out);
    settings.force = true;  // its own folders, one a law
    settings.quiet = true;
    settings.report = false;
    runs.push_back(run_scene(paper_scene(a.mesh, e, a.set), settings));
    report["table"].push_back(table_row(e, runs.back()));
    if (runs.back().result.stopped) throw RunError("paper: stopped before all experiments were done");
  }
  report["claims"] = check_claims(runs, 0.2);
  write_file_whole(a.out + "/paper.json", json_text(report, 2) + "\n");
  write_json(a.json_file, json_text(report, 2) + "\n");
  print(report);
  write_paper_report(a.out);
  std::cout << "  results  " << a.out << "/paper.html\n";
  for (const auto& c : report["claims"])
    if (!c["holds"].get<bool>()) exit_code = 1;
}

}  // namespace

void add_paper_command(CLI::App& app, int& exit_code) {
  auto* command = app.add_subcommand("paper", "the paper's three drag experiments, its claims checked");
  auto a = std::make_shared<PaperArguments>();
  command->add_option("--out", a->out, "folder for the results")->capture_default_str();
  command->add_option("--mesh", a->mesh, "surface to drag over, by default the coarse block");
  command->add_option("--set", a->set, "change a setting of all scenes, KEY=VALUE")->allow_extra_args(false);
  add_json_option(*command, a->json_file, "claims and table");
  command->footer("Example:\n  kilotouch paper --out out/paper");
  command->callback([a, &exit_code] { run_paper(*a, exit_code); });
}

}  // namespace kt
