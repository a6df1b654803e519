// kilotouch paper: the paper's three drag experiments (figures 3, 4, 5) and, beside them, the consistent law.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>

#include "apps/commands.hpp"
#include "apps/report.hpp"
#include "apps/run_session.hpp"
#include "core/error.hpp"
#include "haptics/metrics.hpp"
#include "io/json_file.hpp"
#include "io/output_file.hpp"

namespace kt {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kRoundoff = 1e-12;  // |F_T| of pure sliding against F_N: one projection in double precision
constexpr double kCone = 1e-9;       // slack of F_T <= mu F_N

struct Experiment {
  std::string folder, law, metric, integrator;
  double mu;
};

// The paper's own numerics, then the same drags with the consistent law.
const std::vector<Experiment> kExperiments = {
    {"slide", "paper_slide", "identity", "symplectic_euler", 0},
    {"stick", "paper_stick", "identity", "symplectic_euler", 0},
    {"stick_slip", "paper_stick_slip", "identity", "symplectic_euler", 1},
    {"coulomb_slide", "coulomb", "implicit", "implicit_euler", 0},
    {"coulomb", "coulomb", "implicit", "implicit_euler", 1},
};

/// A coarse block (5 mm triangles), pressed by a point and dragged across its top.
Scene paper_scene(const std::string& mesh, const Experiment& e, const std::vector<std::string>& set) {
  Scene scene = default_scene();
  scene.title = e.law;
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
  scene.global.rate_hz = 30;
  scene.global.integrator = "implicit_euler";
  scene.local.integrator = e.integrator;
  return parse_scene(to_json(scene), set, "paper");
}

/// The largest drop of F_T within ten ticks of a transition that comes after ten ticks of sticking, as a share of F_T.
double largest_slip_drop(const std::vector<LocalFrame>& frames, double from) {
  constexpr std::size_t kTicks = 10;
  double out = 0;
  std::size_t stuck = 0;  // ticks in a row, up to this one
  for (std::size_t i = 1; i < frames.size(); ++i) {
    stuck = frames[i - 1].mode == ContactMode::stick ? stuck + 1 : 0;
    if (frames[i].t < from || stuck < kTicks || frames[i].mode != ContactMode::frictional_slide) continue;
    const double before = frames[i - 1].f_t;
    double least = before;
    for (std::size_t k = i; k < std::min(i + kTicks, frames.size()); ++k) least = std::min(least, frames[k].f_t);
    out = std::max(out, 1 - least / before);
  }
  return out;
}

int stick_to_slip(const std::vector<LocalFrame>& frames) {
  int count = 0;
  for (std::size_t i = 1; i < frames.size(); ++i)
    count += frames[i - 1].mode == ContactMode::stick && frames[i].mode == ContactMode::frictional_slide;
  return count;
}

double largest_ratio(const std::vector<LocalFrame>& frames) {
  double out = 0;
  for (const LocalFrame& f : frames)
    if (f.f_n > 0) out = std::max(out, f.f_t / f.f_n);
  return out;
}

Json claim(const std::string& what, double value, const std::string& bound, bool holds) {
  return {{"text", what}, {"value", value}, {"bound", bound}, {"holds", holds}};
}

Json check_claims(const std::vector<RunOutcome>& runs, double pressed) {
  const auto& slide = runs[0].summary["force"];
  const double sliding = slide["max_t"].get<double>() / slide["max_n"].get<double>();
  const double sticking = largest_ratio(runs[1].result.frames);
  const double cone = measure_forces(runs[2].result.frames, pressed, 1e-3).max_t_over_n;
  const double drop = largest_slip_drop(runs[2].result.frames, pressed);
  return {claim("Pure sliding: largest F_T / largest F_N (the paper's figure 3: no tangential force)", sliding,
                "< 1e-12", sliding < kRoundoff && slide["max_n"].get<double>() > 0),
          claim("Pure sticking: largest F_T / F_N (figure 4: F_T exceeds F_N)", sticking, "> 1", sticking > 1),
          claim("Stick-slip, mu = 1: largest F_T / (mu F_N) over all ticks (figure 5)", cone, "<= 1 + 1e-9",
                cone > 0 && cone <= 1 + kCone),
          claim("Stick-slip: transitions from sticking to sliding", stick_to_slip(runs[2].result.frames), ">= 1",
                stick_to_slip(runs[2].result.frames) >= 1),
          claim("Stick-slip: largest drop of F_T within 10 ms of a transition, share of F_T", drop, "> 0", drop > 0)};
}

Json table_row(const Experiment& e, const RunOutcome& run) {
  const auto& s = run.summary;
  return {{"law", e.law},
          {"metric", e.metric},
          {"mu", e.law == "paper_stick" ? Json() : Json(e.mu)},  // it has none
          {"integrator", e.integrator},
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
  std::printf("  %-17s %-9s %4s %9s %9s %8s %14s %13s %8s\n", "law", "metric", "mu", "F_N [N]", "F_T [N]", "buzz",
              "crossing jump", "refresh jump", "step us");
  for (const auto& r : report["table"])
    std::printf("  %-17s %-9s %4s %9.4f %9.4f %7.1f%% %13.1f%% %12.1f%% %8.2f\n", r["law"].get<std::string>().c_str(),
                r["metric"].get<std::string>().c_str(), r["mu"].is_null() ? "-" : text(r["mu"].get<double>()).c_str(),
                r["mean_n"].get<double>(), r["mean_t"].get<double>(), 100 * r["buzz"].get<double>(),
                100 * r["crossing_jump"].get<double>(), 100 * r["refresh_jump"].get<double>(),
                r["step_us_p50"].get<double>());
}

std::string find_block() {
  for (const char* candidate : {KT_MESHES_INSTALLED, KT_MESHES_SOURCE})
    if (std::filesystem::exists(std::string(candidate) + "/block.msh")) return std::string(candidate) + "/block.msh";
  throw InputError("paper: meshes/block.msh is missing; name a mesh with --mesh");
}

struct PaperArguments {
  std::string out = "out/paper", mesh, json_file;
  std::vector<std::string> set;
};

void run_paper(PaperArguments a, int& exit_code) {
  if (a.mesh.empty()) a.mesh = find_block();
  std::vector<RunOutcome> runs;
  Json report{{"claims", Json::array()}, {"table", Json::array()}};
  for (const Experiment& e : kExperiments) {
    RunSettings settings;
    settings.out = a.out + "/" + e.folder;
    settings.force = true;  // its own folders, one a law
    settings.quiet = true;
    settings.report = false;
    runs.push_back(run_scene(paper_scene(a.mesh, e, a.set), settings));
    report["table"].push_back(table_row(e, runs.back()));
    if (runs.back().result.stopped) throw RunError("paper: stopped before all experiments were done");
  }
  report["claims"] = check_claims(runs, 0.2);
  write_file_whole(a.out + "/paper.json", json_text(report, 2) + "\n");
  if (!a.json_file.empty()) write_file_whole(a.json_file, json_text(report, 2) + "\n");
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
  command->add_option("--mesh", a->mesh, "surface to drag over; default: the coarse block");
  command->add_option("--set", a->set, "change a setting of all four scenes, KEY=VALUE")->allow_extra_args(false);
  command->add_option("--json", a->json_file, "also write claims and table to this file");
  command->footer("Example:\n  kilotouch paper --out out/paper");
  command->callback([a, &exit_code] { run_paper(*a, exit_code); });
}

}  // namespace kt
