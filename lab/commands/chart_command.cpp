// kilotouch chart: speed against accuracy, all methods on standard scenes or on yours.
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <thread>

#include "apps/console/commands.hpp"
#include "apps/console/data_files.hpp"
#include "apps/console/finite_number.hpp"
#include "apps/console/report.hpp"
#include "apps/console/words.hpp"
#include "apps/run/run_session.hpp"
#include "core/base/error.hpp"
#include "io/files/json_file.hpp"
#include "io/files/output_file.hpp"
#include "io/files/output_folder.hpp"
#include "lab/chart/point.hpp"
#include "lab/chart/run_matrix.hpp"
#include "lab/commands/laboratory.hpp"
#include "lab/study/reference.hpp"

namespace kt {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct ChartArguments {
  std::vector<std::string> scenes;
  std::string json_file;
  ChartSettings settings;
  bool full = false, no_report = false;
};

std::string standard_scene(const std::string& name) {
  if (const fs::path file = find_data(fs::path("scenes") / name); !file.empty()) return fs::relative(file).string();
  throw InputError(text("chart: ", name, " is not in share/kilotouch/scenes beside the program's bin"));
}

/// Forces can be compared along one tool path only, and with a full model that does what the scene asks for.
void check_scene(const std::string& file) {
  const Scene scene = load_scene(file, {});
  if (scene.tool.path.hand)
    throw InputError(text(file,
                          ": tool.path.hand: the hand answers to the force, so that every method has a path of its "
                          "own; a chart needs press_drag, waypoints or a recording"));
  if (scene.tool.path.device)
    throw InputError(text(file,
                          ": tool.path.device: whoever holds the device goes another way each time; a chart needs "
                          "press_drag, waypoints or a recording: record a session and chart its recording.csv"));
  if (scene.global.self_contact)
    throw InputError(text(file,
                          ": global.self_contact: the full model in fine steps, which is the truth of the chart, "
                          "passes through itself"));
  if (scene.second_tool)
    throw InputError(text(file, ": second_tool: a chart compares the force on one tool; most methods know no other"));
}

std::vector<ChartMatrix> matrices(const ChartArguments& a) {
  std::vector<ChartMatrix> out;
  if (a.scenes.empty())
    out = {drag_matrix(standard_scene("chart_drag.json"), a.full),
           press_matrix(standard_scene("chart_press.json"), a.full)};
  for (const std::string& scene : a.scenes) {
    check_scene(scene);
    ChartMatrix matrix = scene_matrix(scene, a.full);
    for (const ChartMatrix& other : out)
      if (other.name == matrix.name)
        throw InputError(text("chart: two scenes are called ", matrix.name, ": ", other.scene, " and ", scene));
    out.push_back(std::move(matrix));
  }
  return out;
}

std::string processor_name() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown";
}

std::string csv_cell(const Json& value) {
  if (value.is_null()) return "";
  if (!value.is_string()) return value.dump();
  std::string out(1, '"');
  for (const char c : value.get<std::string>()) {
    if (c == '"') out += c;
    out += c == '\n' ? ' ' : c;
  }
  out += '"';
  return out;
}

std::string chart_csv(const Json& chart) {
  std::string out = "chart,body,family,label,nodes,dof";
  for (const ChartAxis& axis : chart_axes()) out += text(",", axis.key);
  out += ",real_time,lost_contacts,pareto,outcome,trouble,hash,command\n";
  for (const Json& matrix : chart["charts"])
    for (const Json& point : matrix["points"]) {
      out += csv_cell(matrix["name"]);
      for (const char* key : {"body", "family", "label", "nodes", "dof"}) (out += ',') += csv_cell(point[key]);
      for (const ChartAxis& axis : chart_axes()) (out += ',') += csv_cell(point[axis.key]);
      for (const char* key : {"real_time", "lost_contacts", "pareto", "outcome", "trouble", "hash", "command"})
        (out += ',') += csv_cell(point[key]);
      out += "\n";
    }
  return out;
}

void print_chart(const Json& chart) {
  for (const Json& matrix : chart["charts"]) {
    std::cout << matrix["title"].get<std::string>() << '\n';
    for (const Json& truth : matrix["references"]) {
      std::cout << "  truth         " << truth["what"].get<std::string>();
      if (truth.contains("trouble")) std::cout << ": FAILED: " << truth["trouble"].get<std::string>();
      if (truth.contains("doubt")) std::cout << ": its run doubts it: " << truth["doubt"].get<std::string>();
      if (truth.contains("change_by_halving") && truth["change_by_halving"].is_number())
        std::printf(", %s: %.2g %% from steps twice as long", truth["body"].get<std::string>().c_str(),
                    100 * truth["change_by_halving"].get<double>());
      std::cout << '\n' << std::flush;
    }
    std::printf("    %-30s %-18s %-30s %9s %9s %9s %9s  %s\n", "body", "family", "method", "error %", "tick us",
                "p99.9 us", "refr. ms", "real time");
    for (const Json& p : matrix["points"]) {
      const auto word = [&](const char* key) { return p[key].get<std::string>(); };
      const auto number = [&](const char* key) { return p[key].is_number() ? p[key].get<double>() : NAN; };
      std::printf("  %c %-30s %-18s %-30s ", p["pareto"].get<bool>() ? '*' : ' ', word("body").c_str(),
                  word("family").c_str(), word("label").c_str());
      if (p["outcome"] == "done")
        std::printf("%9.3g %9.3g %9.3g %9.3g  %s\n", number("force_error"), number("tick_p50_us"),
                    number("tick_p999_us"), number("refresh_ms"),
                    p["real_time"].is_string() ? word("real_time").c_str() : "-");
      else
        std::printf("%s: %s\n", word("outcome").c_str(), word("trouble").c_str());
    }
  }
  std::cout << "  * no other method is both faster (median tick) and more exact\n" << std::flush;
}

int run_chart(ChartArguments& a) {
  const std::vector<ChartMatrix> all = matrices(a);
  const OutputFolder folder(a.settings.out, "--out " + a.settings.out, {"chart.json", "chart.csv", "chart.html"});
  a.settings.stop = &stop_requested();
  a.settings.progress = progress_bar("charting");
  const auto start = std::chrono::steady_clock::now();
  Json chart{{"processor", processor_name()}, {"noticeable", kNoticeableForce}};
  for (const ChartAxis& axis : chart_axes())
    chart["axes"].push_back({{"key", axis.key}, {"title", axis.title}, {"is_cost", axis.is_cost}});
  chart["charts"] = run_matrices(all, a.settings);
  chart["seconds"] = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  chart["stopped"] = stop_requested().load();
  write_file_whole(a.settings.out + "/chart.json", json_text(chart, 1) + "\n");
  write_file_whole(a.settings.out + "/chart.csv", chart_csv(chart));
  write_json(a.json_file, json_text(chart, 1) + "\n");
  print_chart(chart);
  const bool drawn = !a.no_report && !stop_requested() && write_chart_report(a.settings.out);
  std::printf("  results       %s (%.0f s)\n", (a.settings.out + (drawn ? "/chart.html" : "/chart.csv")).c_str(),
              chart["seconds"].get<double>());
  return stop_requested() ? 1 : 0;
}

}  // namespace

void add_chart_command(CLI::App& app, int& exit_code) {
  auto* command = app.add_subcommand("chart", "speed against accuracy, for all methods");
  auto a = std::make_shared<ChartArguments>();
  a->settings.out = "chart";
  a->settings.jobs = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  command->add_option("SCENE", a->scenes, "scene files. Without them the standard ones");
  command->add_option("--out", a->settings.out, "folder for the results")->capture_default_str();
  add_json_option(*command, a->json_file, "chart.json");
  command->add_flag("--full", a->full, "every rate, material and mesh, in hours. --resume goes on after a stop");
  command->add_option("--jobs", a->settings.jobs, "runs side by side")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command->add_flag("--resume", a->settings.resume, "keep the runs that are in the folder already");
  auto* timeout = command->add_option("--timeout", a->settings.seconds, "limit of one run [s], with --full 3600")
                      ->check(number_within(1, 1e6))
                      ->capture_default_str();
  command->add_option("--reference-rate", a->settings.reference_hz, "steps of the full model that is the truth [Hz]")
      ->check(number_within(2000, 1e6))
      ->capture_default_str();
  command->add_flag("--no-report", a->no_report, "numbers only, without pictures and chart.html");
  command->footer(
      "Example:\n  kilotouch chart --out chart\n  kilotouch chart scenes/organ_drag.json --out chart_organ");
  command->callback([a, timeout, &exit_code] {
    if (a->full && timeout->empty())
      a->settings.seconds = 3600;  // its finest mesh takes minutes, and more beside other work
    exit_code = run_chart(*a);
  });
}

}  // namespace kt
