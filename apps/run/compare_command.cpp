// kilotouch compare RUN RUN...: what differs between runs, and would a person notice.
#include <cstdio>
#include <filesystem>
#include <iostream>

#include "apps/console/commands.hpp"
#include "apps/console/report.hpp"
#include "apps/console/words.hpp"
#include "apps/run/compared_runs.hpp"
#include "core/base/error.hpp"
#include "core/base/numbers.hpp"
#include "io/files/json_file.hpp"
#include "io/files/output_file.hpp"
#include "io/files/output_folder.hpp"

namespace kt {
namespace {

using Json = nlohmann::ordered_json;

struct CompareArguments {
  std::vector<std::string> runs;
  std::string out = "out/compare", json_file;
  bool no_report = false;
};

const char* noticed_word(Noticed noticed) {
  constexpr const char* kWords[] = {"no", "perhaps", "yes", "not judged"};
  return kWords[static_cast<int>(noticed)];
}

Json difference_json(const ForceDifference& d) {
  return {{"seconds", d.seconds},
          {"rms_n", d.rms_n},
          {"rms_share", d.rms_share},
          {"largest_n", d.largest_n},
          {"largest_share", d.largest_share},
          {"largest_at_s", d.at},
          {"beyond_7_percent", d.perhaps_share},
          {"beyond_10_percent", d.surely_share},
          {"common_contact_s", d.common_contact},
          {"tools_apart_m", d.apart},
          {"same_bits", d.same_bits},
          {"noticed", d.noticed == Noticed::not_judged ? Json() : Json(noticed_word(d.noticed))}};
}

std::string scene_title(const Json& scene) {
  if (scene.contains("title") && scene["title"].is_string() && !scene["title"].get<std::string>().empty())
    return scene["title"].get<std::string>();
  const auto mesh = Json::json_pointer("/object/mesh");
  return scene.contains(mesh) && scene[mesh].is_string() ? scene[mesh].get<std::string>() : "run";
}

Json compared_run_json(const ComparedRun& run) {
  return {{"name", run.name},
          {"folder", std::filesystem::absolute(run.folder).lexically_normal().string()},
          {"scene", scene_title(run.scene)},
          {"hash", run.summary.value("hash", Json(nullptr))}};
}

/// In one line.
std::string told_difference(const ComparedRun& first, const ForceDifference& d) {
  if (d.same_bits) return "the same forces, bit for bit";
  return text("RMS ", short_number(d.rms_n), " N, ", in_percent(d.rms_share), " of ", first.name, "'s; largest ",
              short_number(d.largest_n), " N, ", in_percent(d.largest_share), " of its largest force, at ",
              short_number(d.at), " s");
}

std::string told_noticed(const ForceDifference& d) {
  if (d.noticed == Noticed::not_judged)
    return text("not judged: in no tick of the ", short_number(d.seconds), " s that both have do both touch the body");
  const std::string beyond = text("beyond 10 % in ", in_percent(d.surely_share),
                                  " of the time with a force, beyond 7 % in ", in_percent(d.perhaps_share));
  return text(noticed_word(d.noticed), ": ", d.perhaps_share > 0 ? beyond : "nowhere beyond 7 %",
              " (people tell forces apart that differ by 7 to 10 %)");
}

void print_settings(const std::vector<ChangedSetting>& settings) {
  constexpr std::size_t kShown = 20;
  if (settings.empty()) std::cout << "  settings  the same\n";
  for (std::size_t i = 0; i < std::min(kShown, settings.size()); ++i) {
    std::cout << (i == 0 ? "  settings  " : "            ") << settings[i].key << ": ";
    for (std::size_t k = 0; k < settings[i].values.size(); ++k) {
      const Json& value = settings[i].values[k];
      std::cout << (k > 0 ? " | " : "") << (value.is_null() ? "not set" : shown_json(value));
    }
    std::cout << '\n';
  }
  if (settings.size() > kShown) std::cout << "            ... and " << settings.size() - kShown << " more\n";
}

void compare_all(const CompareArguments& a) {
  const OutputFolder place(a.out, "--out " + a.out, {"compare.json", "compare.html"});
  std::vector<ComparedRun> runs;
  for (const std::string& folder : a.runs) runs.push_back(read_run(folder));
  for (std::size_t k = 1; k < runs.size(); ++k)  // equal names: by their folders
    for (std::size_t i = 0; i < k; ++i)
      if (runs[i].name == runs[k].name) {
        runs[i].name = runs[i].folder;
        runs[k].name = runs[k].folder;
      }
  const std::vector<ChangedSetting> settings = changed_settings(runs);
  Json out{{"runs", Json::array()}, {"settings", Json::array()}, {"forces", Json::array()}};
  for (const ComparedRun& run : runs) out["runs"].push_back(compared_run_json(run));
  for (const ChangedSetting& s : settings) out["settings"].push_back({{"key", s.key}, {"values", s.values}});
  std::cout << runs[0].name << ": " << scene_title(runs[0].scene) << '\n';
  print_settings(settings);
  for (std::size_t k = 1; k < runs.size(); ++k) {
    const ForceDifference d = compare_runs(runs[0], runs[k]);
    Json one{{"run", runs[k].name}, {"against", runs[0].name}};
    one.update(difference_json(d));
    const bool has_second = runs[0].tools.size() > 1 && runs[k].tools.size() > 1;
    const ForceDifference second = has_second ? compare_runs(runs[0], runs[k], 1) : ForceDifference();
    if (has_second) one["second_tool"] = difference_json(second);
    out["forces"].push_back(one);
    std::cout << runs[k].name << ": " << scene_title(runs[k].scene) << "\n  force     " << told_difference(runs[0], d)
              << "\n  noticed   " << told_noticed(d) << '\n';
    if (has_second)
      std::cout << "  second    " << told_difference(runs[0], second) << "\n  noticed   " << told_noticed(second)
                << '\n';
    constexpr double kSamePath = 1e-6;  // [m]
    if (d.apart > kSamePath)
      std::cout << "  tools     up to " << short_number(1e3 * d.apart)
                << " mm apart: they went different ways, which alone makes other forces\n";
    if (runs[0].h * static_cast<double>(runs[0].tools[0].force.size()) > d.seconds + runs[0].h)
      std::cout << "  time      only the first " << short_number(d.seconds) << " s, which both have\n";
  }
  write_file_whole(a.out + "/compare.json", json_text(out, 2) + "\n");
  write_json(a.json_file, json_text(out, 2) + "\n");
  if (!a.no_report && !stop_requested()) write_compare_page(a.out);
  std::cout << "  results   " << a.out << (a.no_report ? "/compare.json" : "/compare.html") << '\n';
}

}  // namespace

void add_compare_command(CLI::App& app, int& exit_code) {
  auto* command =
      app.add_subcommand("compare", "differences of runs in settings and force, and whether a person would notice");
  auto a = std::make_shared<CompareArguments>();
  command->add_option("RUN", a->runs, "folders with the results of runs. The first is compared with the others")
      ->required()
      ->expected(2, 16);
  command->add_option("--out", a->out, "folder for the results")->capture_default_str();
  add_json_option(*command, a->json_file, "compare.json");
  command->add_flag("--no-report", a->no_report, "numbers only, without compare.html");
  command->footer(
      "Example:\n  kilotouch run scenes/slab_drag.json --out out/a && kilotouch run scenes/slab_drag.json --set "
      "contact.mu=0.8 --out out/b && kilotouch compare out/a out/b");
  command->callback([a, &exit_code] {
    compare_all(*a);
    exit_code = 0;
  });
}

}  // namespace kt
