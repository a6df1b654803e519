// kilotouch advise SCENE.json: which model, mesh, global rate and reducer is the cheapest within a tolerance.
#include <cmath>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>

#include "apps/console/commands.hpp"
#include "apps/console/words.hpp"
#include "apps/run/run_session.hpp"
#include "io/files/json_file.hpp"
#include "io/files/output_file.hpp"
#include "lab/advise/advise.hpp"
#include "lab/commands/laboratory.hpp"

namespace kt {
namespace {

using Json = nlohmann::ordered_json;

struct AdviseArguments {
  std::string scene, json_file;
  std::vector<std::string> set;
  AdviseOptions options;
};

std::string form(const char* format, double value) {
  char out[64];
  std::snprintf(out, sizeof out, format, value);
  return std::isnan(value) ? "-" : out;
}
std::string percent(double value) { return form("%.1f %%", 100 * value); }

std::string verdict(const Candidate& c, double tolerance, const std::string& note) {
  if (!note.empty()) return "not judged: " + note;
  const auto [limit, by] = worst_limit(c, tolerance);
  if (by <= 1) return "fits";
  const char* what = limit == Limit::error       ? "off: %.2g x the tolerance"
                     : limit == Limit::slow_load ? "too slow: %.2g x its interval"
                                                 : "too slow: tick %.2g x its period";
  return form(what, by) + (limit == Limit::error && !is_real_time(c) ? ", too slow" : "");
}

/// Yes or no, and the shares of both budgets.
std::string real_time(const Candidate& c) {
  return text(is_real_time(c) ? "yes" : "no", form(": refresh %.0f", 100 * c.slow_load),
              form(", tick %.2g %%", 100 * c.tick_load));
}

std::string mesh_name(const AdviceBody& b) { return b.mesh_name + (b.refined ? ", refined" : ""); }

std::string body_name(const AdviceBody& b) { return b.model + ", mesh " + mesh_name(b); }

void print_bodies(const Advice& a) {
  const AdviceTruth& truth = a.truth;
  std::cout << "model and mesh";
  if (truth.why_none.empty())
    std::cout << ", pressed " << form("%.3g mm", 1e3 * truth.depth)
              << " at rest; truth: " << form("%.4g N", truth.force) << " +- " << percent(truth.uncertainty)
              << " (tet10, " << truth.nodes << " nodes)";
  std::printf("\n    %-6s %-22s %6s %6s %7s %9s %8s %8s  %s\n", "model", "mesh", "nodes", "cell/a", "expect", "force N",
              "error", "ms/refr.", "verdict");
  for (const AdviceBody& b : a.bodies)
    std::printf("  %s %-6s %-22s %6s %6s %7s %9s %8s %8s  %s\n",
                a.row.index >= 0 && &b == &a.bodies[a.rows[a.row.index].body] ? "*" : " ", b.model.c_str(),
                mesh_name(b).c_str(), b.nodes > 0 ? std::to_string(b.nodes).c_str() : "-",
                form("%.2g", b.cell_over_contact_radius).c_str(), form("x %.3g", b.expected_factor).c_str(),
                form("%.4g", b.force).c_str(), percent(b.error).c_str(), form("%.3g", b.refresh_ms).c_str(),
                verdict(candidate_of(b), a.tolerance, b.note).c_str());
}

void print_rows(const Advice& a, double local_rate_hz) {
  int body = -1;
  for (const AdviceRow& r : a.rows) {
    const AdviceBody& b = a.bodies[r.body];
    if (r.body != body) {
      std::cout << "global rate and reducer on " << body_name(b);
      if (b.reference_seconds > 0)
        std::cout << "; against its full model at " << b.reference_rate_hz << " Hz for "
                  << form("%.2g s", b.reference_seconds) << " of the path";
      std::printf("\n    %4s  %-10s %8s %8s %11s %9s %8s  %-22s %s\n", "Hz", "reducer", "error", "+ body", "ms/refresh",
                  "us/tick", "a core", "real time", "verdict");
      body = r.body;
    }
    const bool is_known = std::isfinite(r.rates_error);
    std::printf("  %s %4g  %-10s %8s %8s %11s %9s %8s  %-22s %s\n",
                a.row.index >= 0 && &r == &a.rows[a.row.index] ? "*" : " ", r.rate_hz, r.reducer.c_str(),
                percent(r.rates_error).c_str(), percent(r.error).c_str(),
                is_known ? form("%.3g", r.global_ms + r.refresh_ms).c_str() : "-",
                is_known ? form("%.3g", r.tick_us).c_str() : "-", percent(r.core_share).c_str(),
                is_known ? real_time(candidate_of(r, local_rate_hz)).c_str() : "-",
                verdict(candidate_of(r, local_rate_hz), a.tolerance, r.note).c_str());
  }
}

int count_unjudged(const Advice& a) {
  const auto open = [](const auto& row) { return !row.note.empty(); };
  return static_cast<int>(std::ranges::count_if(a.bodies, open) + std::ranges::count_if(a.rows, open));
}

/// One sentence.
std::string reason(const Advice& a, double local_rate_hz) {
  if (a.row.index < 0) return "nothing could be judged; raise --budget-seconds";
  const AdviceRow& r = a.rows[a.row.index];
  const std::string what = text(body_name(a.bodies[r.body]), ", ", r.rate_hz, " Hz, ", r.reducer, ": ");
  const std::string error = "force off by " + percent(r.error);
  if (!a.found())
    return text("none is within ", percent(a.tolerance), " and real time; nearest: ", what,
                verdict(candidate_of(r, local_rate_hz), a.tolerance, ""), ", ", error);
  if (!a.truth.why_none.empty())
    return text("the cheapest rate and reducer on the scene's own body, which is not judged: ", what, error);
  return text("the cheapest within ", percent(a.tolerance), ": ", what, error, ", ", percent(r.core_share),
              " of a core");
}

/// The last line: what to type.
void print_recommendation(const Advice& a, const AdviseArguments& arguments) {
  if (a.settings.empty()) {
    std::cout << "recommended: kilotouch advise " << arguments.scene << " --budget-seconds "
              << 4 * arguments.options.budget_seconds << ": no row could be judged in the time\n";
    return;
  }
  std::cout << (a.found() ? "recommended" : "nearest, not within the tolerance") << ": kilotouch run "
            << arguments.scene;
  for (const std::string& s : arguments.set) std::cout << " --set " << s;
  for (const std::string& s : a.settings) std::cout << " --set " << s;
  std::cout << '\n';
}

void print_advice(const Advice& a, double local_rate_hz) {
  print_bodies(a);
  print_rows(a, local_rate_hz);
  std::printf("took %.0f s", a.seconds);
  if (const int open = count_unjudged(a)) std::printf("; %d rows not judged", open);
  std::cout << (a.stopped ? "; stopped\n" : "\n") << reason(a, local_rate_hz) << '\n';
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json advice_json(const Advice& a, const Scene& scene) {
  Json out{{"scene", scene.title},
           {"tolerance", a.tolerance},
           {"found", a.found()},
           {"reason", reason(a, scene.local.rate_hz)},
           {"settings", a.settings},
           {"row", a.row.index < 0 ? Json() : Json(a.row.index)},
           {"seconds", a.seconds},
           {"stopped", a.stopped},
           {"truth",
            {{"nodes", a.truth.nodes},
             {"depth", a.truth.depth},
             {"force", number(a.truth.force)},
             {"uncertainty", number(a.truth.uncertainty)},
             {"why_none", a.truth.why_none}}},
           {"bodies", Json::array()},
           {"rows", Json::array()}};
  for (const AdviceBody& b : a.bodies)
    out["bodies"].push_back({{"model", b.model},
                             {"mesh", b.mesh_name},
                             {"refined", b.refined},
                             {"nodes", b.nodes},
                             {"force", number(b.force)},
                             {"error", number(b.error)},
                             {"cell_over_contact_radius", number(b.cell_over_contact_radius)},
                             {"expected_factor", number(b.expected_factor)},
                             {"refresh_ms", number(b.refresh_ms)},
                             {"reference_seconds", b.reference_seconds},
                             {"verdict", verdict(candidate_of(b), a.tolerance, b.note)}});
  for (const AdviceRow& r : a.rows)
    out["rows"].push_back({{"body", r.body},
                           {"rate_hz", r.rate_hz},
                           {"reducer", r.reducer},
                           {"rates_error", number(r.rates_error)},
                           {"error", number(r.error)},
                           {"global_ms", r.global_ms},
                           {"refresh_ms", r.refresh_ms},
                           {"refreshes_per_second", r.refreshes_per_second},
                           {"step_us", {{"p99", r.tick_us}}},
                           {"core_share", number(r.core_share)},
                           {"real_time", is_real_time(candidate_of(r, scene.local.rate_hz))},
                           {"refresh_share", number(candidate_of(r, scene.local.rate_hz).slow_load)},
                           {"tick_share", number(candidate_of(r, scene.local.rate_hz).tick_load)},
                           {"verdict", verdict(candidate_of(r, scene.local.rate_hz), a.tolerance, r.note)}});
  return out;
}

void check(const AdviseOptions& options) {
  if (!(options.tolerance > 0 && options.tolerance <= 10))
    throw InputError(text("--tolerance: ", options.tolerance, ", must be above 0, at most 10 (0.05 is five per cent)"));
  if (!(options.budget_seconds >= 1 && options.budget_seconds <= 86400))
    throw InputError(text("--budget-seconds: ", options.budget_seconds, ", must be 1 .. 86400"));
}

}  // namespace

void add_advise_command(CLI::App& app, int& exit_code) {
  auto* command = app.add_subcommand("advise", "the cheapest model, mesh, rate and reducer within a tolerance");
  auto a = std::make_shared<AdviseArguments>();
  command->add_option("SCENE", a->scene, "scene file (docs/scene.md)")->required();
  command->add_option("--set", a->set, "change a setting of the scene, KEY=VALUE, as often as needed")
      ->allow_extra_args(false);
  command->add_option("--tolerance", a->options.tolerance, "largest error of the force, relative")
      ->capture_default_str();
  command
      ->add_option("--budget-seconds", a->options.budget_seconds,
                   "wall clock [s]. Bodies and rates beyond it are left out and named")
      ->capture_default_str();
  add_json_option(*command, a->json_file, "all rows");
  command->footer("Example:\n  kilotouch advise scenes/slab_drag.json --tolerance 0.1");
  command->callback([a, &exit_code] {
    check(a->options);
    const Scene scene = load_scene(a->scene, a->set);
    a->options.progress = progress_bar(scene.title.empty() ? "advising" : scene.title);
    a->options.stop = &stop_requested();
    const Advice advice = kt::advise(scene, a->options);
    print_advice(advice, scene.local.rate_hz);
    print_recommendation(advice, *a);
    write_json(a->json_file, json_text(advice_json(advice, scene), 2) + "\n");
    exit_code = advice.found() && !advice.stopped ? 0 : 1;
  });
}

}  // namespace kt
