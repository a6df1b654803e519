// kilotouch advise SCENE.json: which model, mesh, global rate and reducer is the cheapest within a tolerance.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>

#include "apps/commands.hpp"
#include "apps/run_session.hpp"
#include "haptics/advise.hpp"
#include "io/output_file.hpp"

namespace kt {
namespace {

using Json = nlohmann::ordered_json;

struct AdviseArguments {
  std::string scene, json_file;
  std::vector<std::string> set;
  AdviseOptions options;
};

/// printf with a std::string.
template <class... Args>
std::string form(const char* format, const Args&... args) {
  char out[512];
  std::snprintf(out, sizeof out, format, args...);
  return out;
}

std::string percent_or_dash(double value) { return std::isnan(value) ? "-" : form("%.1f %%", 100 * value); }

/// "fits", or the limit that is missed by most.
std::string verdict(const Candidate& c, double tolerance, const std::string& note) {
  if (!c.measured) return note;
  if (std::isnan(c.error)) return note;
  const auto [limit, by] = worst_limit(c, tolerance);
  std::string out = "fits";
  if (by > 1) {
    out = limit == Limit::error ? "off" : limit == Limit::slow_load ? "too slow" : "tick too slow";
    out += form(" (%.3g x what is allowed)", by);
  }
  return note.empty() ? out : out + "; " + note;
}

/// Indices, the cheapest first; what was not measured last, as it came.
template <class Rows, class Cost>
std::vector<int> by_cost(const Rows& rows, const Cost& cost) {
  std::vector<int> order(rows.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  std::ranges::stable_sort(order, [&](int l, int r) {
    if (rows[l].measured != rows[r].measured) return rows[l].measured;
    return rows[l].measured && cost(rows[l]) < cost(rows[r]);
  });
  return order;
}

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json body_json(const AdviceBody& b, double tolerance) {
  return {{"model", b.model},
          {"max_volume", b.max_volume ? Json(*b.max_volume) : Json()},
          {"nodes", b.nodes},
          {"tets", b.tetrahedra},
          {"measured", b.measured},
          {"force", number(b.force)},
          {"error", number(b.error)},
          {"global_ms", number(b.global_ms)},
          {"verdict", verdict(candidate_of(b), tolerance, b.note)}};
}

Json row_json(const AdviceRow& r, double tolerance, double local_rate_hz) {
  Json out{{"rate_hz", r.rate_hz}, {"reducer", r.reducer}, {"measured", r.measured}};
  if (r.measured)
    out.update({{"error", number(r.error)},
                {"jnd_fraction", number(r.jnd_fraction)},
                {"global_ms", r.global_ms},
                {"refresh_ms", r.refresh_ms},
                {"refreshes_per_second", r.refreshes_per_second},
                {"step_us", {{"p50", r.step_us_p50}, {"p99", r.step_us_p99}}},
                {"core_share", number(r.core_share)},
                {"dof", r.dof}});
  out["verdict"] = verdict(candidate_of(r, local_rate_hz), tolerance, r.note);
  return out;
}

Json advice_json(const Advice& a, const Scene& scene) {
  Json out{{"scene", scene.title},
           {"tolerance", a.tolerance},
           {"found", a.found()},
           {"reason", a.reason},
           {"settings", a.settings},
           {"body", a.body.index < 0 ? Json() : Json(a.body.index)},
           {"row", a.row.index < 0 ? Json() : Json(a.row.index)},
           {"truth",
            {{"what", a.truth.what},
             {"nodes", a.truth.nodes},
             {"tets", a.truth.tetrahedra},
             {"force", number(a.truth.force)},
             {"uncertainty", number(a.truth.uncertainty)}}},
           {"bodies", Json::array()},
           {"reference",
            {{"rate_hz", a.reference.rate_hz},
             {"seconds", a.reference.seconds},
             {"cpu_seconds", a.reference.cpu_seconds},
             {"note", a.reference.note}}},
           {"rows", Json::array()},
           {"notes", a.notes},
           {"seconds", a.seconds},
           {"stopped", a.stopped}};
  for (const AdviceBody& b : a.bodies) out["bodies"].push_back(body_json(b, a.tolerance));
  for (const AdviceRow& r : a.rows) out["rows"].push_back(row_json(r, a.tolerance, scene.local.rate_hz));
  return out;
}

void print_bodies(const Advice& a) {
  std::cout << "model and mesh, pressed in equilibrium\n";
  if (!a.truth.what.empty())
    std::cout << form("  truth: %s, %d nodes, %.4g N", a.truth.what.c_str(), a.truth.nodes, a.truth.force)
              << (std::isnan(a.truth.uncertainty) ? "" : " +- " + percent_or_dash(a.truth.uncertainty)) << '\n';
  std::cout << form("    %-6s %-11s %7s %9s %8s %11s  %s\n", "model", "max_volume", "nodes", "force N", "error",
                    "ms a step", "verdict");
  for (int i : by_cost(a.bodies, [](const AdviceBody& b) { return b.global_ms; })) {
    const AdviceBody& b = a.bodies[i];
    std::cout << form("  %s %-6s %-11s %7d %9s %8s %11s  ", i == a.body.index ? "*" : " ", b.model.c_str(),
                      b.max_volume ? text(*b.max_volume).c_str() : "own", b.nodes,
                      std::isnan(b.force) ? "-" : form("%.4g", b.force).c_str(), percent_or_dash(b.error).c_str(),
                      std::isnan(b.global_ms) ? "-" : form("%.3g", b.global_ms).c_str())
              << verdict(candidate_of(b), a.tolerance, b.note) << '\n';
  }
}

void print_rows(const Advice& a, double local_rate_hz) {
  if (a.rows.empty()) return;
  std::cout << "rates and reducers on " << a.bodies[a.body.index].model;
  if (a.reference.rate_hz > 0)
    std::cout << form(", against the full model at %g Hz over %.3g s%s%s", a.reference.rate_hz, a.reference.seconds,
                      a.reference.note.empty() ? "" : "; it ", a.reference.note.c_str());
  std::cout << form("\n    %5s %-10s %8s %8s %9s %9s %9s %9s %8s  %s\n", "Hz", "reducer", "error", "> JND", "global ms",
                    "refr. ms", "tick p50", "tick p99", "a core", "verdict");
  for (int i : by_cost(a.rows, [](const AdviceRow& r) { return r.core_share; })) {
    const AdviceRow& r = a.rows[i];
    std::cout << form("  %s %5g %-10s ", i == a.row.index ? "*" : " ", r.rate_hz, r.reducer.c_str());
    if (r.measured)
      std::cout << form("%8s %8s %9.3g %9.3g %6.3g us %6.3g us %8s  ", percent_or_dash(r.error).c_str(),
                        percent_or_dash(r.jnd_fraction).c_str(), r.global_ms, r.refresh_ms, r.step_us_p50,
                        r.step_us_p99, percent_or_dash(r.core_share).c_str());
    std::cout << verdict(candidate_of(r, local_rate_hz), a.tolerance, r.note) << '\n';
  }
}

void print_advice(const Advice& a, const Scene& scene) {
  print_bodies(a);
  print_rows(a, scene.local.rate_hz);
  for (const std::string& note : a.notes) std::cout << "  note: " << note << '\n';
  if (a.stopped) std::cout << "  stopped early: what is above is what was measured\n";
  std::cout << (a.found() ? "advice: " : "no advice within the limits: ") << a.reason << '\n';
  if (a.settings.empty()) return;
  std::cout << (a.found() ? "  paste:" : "  nearest:");
  for (const std::string& s : a.settings) std::cout << " --set " << s;
  std::cout << form("\n  took %.0f s", a.seconds) << '\n';
}

void check(const AdviseOptions& options) {
  if (!(options.tolerance > 0 && options.tolerance <= 10))
    throw InputError(text("--tolerance: ", options.tolerance, ", must be above 0, at most 10 (0.05 is five per cent)"));
  if (!(options.budget_seconds >= 1 && options.budget_seconds <= 86400))
    throw InputError(text("--budget-seconds: ", options.budget_seconds, ", must be 1 .. 86400"));
}

}  // namespace

void add_advise_command(CLI::App& app, int& exit_code) {
  auto* command =
      app.add_subcommand("advise", "which model, mesh, rate and reducer is the cheapest within a tolerance");
  auto a = std::make_shared<AdviseArguments>();
  command->add_option("SCENE", a->scene, "scene file (docs/scene.md)")->required();
  command->add_option("--set", a->set, "change a setting of the scene, KEY=VALUE; may be repeated")
      ->allow_extra_args(false);
  command->add_option("--tolerance", a->options.tolerance, "largest error of the force, relative")
      ->capture_default_str();
  command
      ->add_option("--budget-seconds", a->options.budget_seconds, "wall clock; what does not fit is left out and named")
      ->capture_default_str();
  command->add_option("--json", a->json_file, "also write all rows to this file");
  command->footer("Example:\n  kilotouch advise scenes/slab_drag.json --tolerance 0.1");
  command->callback([a, &exit_code] {
    check(a->options);
    require_folder_of(a->json_file);
    const Scene scene = load_scene(a->scene, a->set);
    a->options.progress = progress_bar(scene.title.empty() ? "advising" : scene.title);
    a->options.stop = &stop_requested();
    const Advice advice = advise(scene, a->options);
    print_advice(advice, scene);
    if (!a->json_file.empty()) write_file_whole(a->json_file, advice_json(advice, scene).dump(2) + "\n");
    exit_code = advice.found() && !advice.stopped ? 0 : 1;
  });
}

}  // namespace kt
