// kilotouch stability [MAP...]: where each method works, degrades or fails, measured, from theory and predicted.
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>

#include "apps/console/commands.hpp"
#include "apps/console/report.hpp"
#include "apps/console/words.hpp"
#include "apps/run/run_session.hpp"
#include "io/files/json_file.hpp"
#include "io/files/output_file.hpp"
#include "io/files/output_folder.hpp"
#include "lab/commands/laboratory.hpp"
#include "lab/stability/map_files.hpp"
#include "lab/stability/maps.hpp"

namespace kt {
namespace {

using Json = nlohmann::ordered_json;

struct StabilityArguments {
  std::vector<std::string> maps;
  std::string out = "out/stability", json_file;
  bool full = false, no_report = false;
  int jobs = 2;
};

std::string command_line(const StabilityArguments& a) {
  std::string out = "kilotouch stability";
  for (const std::string& name : a.maps) out += ' ' + name;
  return out + (a.full ? " --full" : "");
}

void print_header() {
  std::printf("%-20s %6s %6s %8s %6s %9s %9s %8s\n", "map", "points", "works", "degrades", "fails", "predicted",
              "false al.", "seconds");
}

void print_row(const std::string& name, const Confusion& c, double seconds) {
  const std::string predicted = c.failures > 0 ? text(c.predicted, "/", c.failures) : "-";
  const std::string alarms = c.alarms() > 0 ? text(c.false_alarms, "/", c.alarms()) : "-";
  std::printf("%-20s %6d %6d %8d %6d %9s %9s %8.1f\n", name.c_str(), c.points, c.working, c.degraded, c.failures,
              predicted.c_str(), alarms.c_str(), seconds);
  std::fflush(stdout);
}

/// Numbers are on disk after every map: Ctrl-C, or a map that throws, loses none of those before it.
Json write_results(const StabilityArguments& a, const std::vector<StabilityMap>& maps, bool stopped) {
  Json out{{"command", command_line(a)}, {"full", a.full}, {"jobs", a.jobs},
           {"stopped", stopped},         {"seconds", 0.0}, {"sum", Json::object()},
           {"maps", Json::array()}};
  Confusion sum;
  double seconds = 0;
  for (const StabilityMap& map : maps) {
    out["maps"].push_back(map_json(map));
    sum.add(count_predictions(map.points));
    seconds += map.seconds;
  }
  out["seconds"] = seconds;
  out["sum"] = confusion_json(sum);
  write_file_whole(a.out + "/stability.json", json_text(out, 2) + "\n");
  return out;
}

void run_stability(const StabilityArguments& a, int& exit_code) {
  const std::vector<MapEntry> chosen = find_maps(a.maps);
  std::vector<std::string> names{"stability.json", "stability.html"};
  for (const MapEntry& entry : chosen)
    names.insert(names.end(), {text(entry.name, ".csv"), text(entry.name, "_boundaries.csv")});
  const OutputFolder folder(a.out, "--out " + a.out, names);
  std::vector<StabilityMap> maps;
  print_header();
  Json results;
  Confusion sum;
  bool has_failed = false;
  write_results(a, maps, true);  // until all are done: a kill leaves what is true
  for (const MapEntry& entry : chosen) {
    if (stop_requested()) break;
    MapOptions options{.full = a.full, .progress = progress_bar(entry.name), .stop = &stop_requested(), .jobs = a.jobs};
    try {
      maps.push_back(make_map(entry, options));
    } catch (const RunError& error) {  // the other maps are worth having all the same
      std::cerr << "kilotouch: stability " << entry.name << ": " << error.what() << '\n';
      has_failed = true;
      continue;
    }
    if (options.progress) options.progress(1);
    const StabilityMap& map = maps.back();
    write_map(a.out, map);
    results = write_results(a, maps, true);
    const Confusion c = count_predictions(map.points);
    sum.add(c);
    print_row(map.name, c, map.seconds);
  }
  results = write_results(a, maps, stop_requested());
  if (maps.size() > 1) print_row("all", sum, results["seconds"].get<double>());
  for (const StabilityMap& map : maps) std::cout << "  " << map.name << ": " << map.claim << '\n';
  write_json(a.json_file, json_text(results, 2) + "\n");
  if (!a.no_report && !stop_requested()) write_stability_report(a.out);
  std::cout << "  results  " << a.out << (a.no_report ? "/stability.json" : "/stability.html") << '\n';
  exit_code = stop_requested() || has_failed ? 1 : 0;
}

}  // namespace

void add_stability_command(CLI::App& app, int& exit_code) {
  auto* command =
      app.add_subcommand("stability", "maps of where each method works, degrades or fails, measured and predicted");
  auto a = std::make_shared<StabilityArguments>();
  std::string known;
  for (const MapEntry& e : stability_maps()) known += (known.empty() ? "" : ", ") + e.name;
  command->add_option("MAP", a->maps, "maps, by default all of " + known);
  command->add_option("--out", a->out, "folder for the results")->capture_default_str();
  add_json_option(*command, a->json_file, "stability.json");
  command->add_flag("--full", a->full, "finer maps of larger bodies, which take far longer");
  command->add_option("--jobs", a->jobs, "threads")->check(CLI::Range(1, 256))->capture_default_str();
  command->add_flag("--no-report", a->no_report, "numbers only, without pictures and stability.html");
  command->footer("Example:\n  kilotouch stability time_step poisson --out out/stability");
  command->callback([a, &exit_code] { run_stability(*a, exit_code); });
}

}  // namespace kt
