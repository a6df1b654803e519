// kilotouch check: collision and contact tests over whole mesh libraries.
#include <algorithm>
#include <filesystem>
#include <iostream>

#include "apps/console/commands.hpp"
#include "apps/console/finite_number.hpp"
#include "apps/console/report.hpp"
#include "apps/console/words.hpp"
#include "apps/run/run_session.hpp"
#include "core/base/error.hpp"
#include "io/files/json_batch.hpp"
#include "io/files/json_file.hpp"
#include "io/files/output_file.hpp"
#include "io/files/output_folder.hpp"
#include "io/solid/lattice.hpp"
#include "lab/check/library.hpp"
#include "lab/check/rows.hpp"
#include "lab/check/worker.hpp"
#include "lab/commands/laboratory.hpp"

namespace kt {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct CheckArguments {
  std::vector<std::string> paths;
  std::string out = "check", shard, baseline, one, json;
  int jobs = 1;
  double timeout = 1200, memory_gb = 4;
  bool resume = false, no_report = false, no_wrap = false;
  CheckOptions check;
};

/// What rows depend on: a run goes on, and reports are joined, only with the same, but for the limits.
Json settings_of(const CheckArguments& a) {
  return {{"body", a.check.body},   {"nodes", a.check.nodes},           {"budget", a.check.budget},
          {"young", a.check.young}, {"quick", a.check.quick},           {"until", a.check.until},
          {"wrap", !a.no_wrap},     {"fill_holes", a.check.fill_holes}, {"backend_seconds", a.check.backend_seconds},
          {"timeout", a.timeout},   {"memory_gb", a.memory_gb}};
}

constexpr const char* kLimits[] = {"timeout", "memory_gb"};

/// The settings beside a file of rows.
Json read_settings(const std::string& rows) {
  const std::string file = rows + ".settings.json";
  Json out = read_json_file(file);
  if (!out.is_object()) throw InputError(file + ": not the settings of a check: not a group");
  for (const char* limit : kLimits)
    if (!out.contains(limit) || !out[limit].is_number())
      throw InputError(text(file, ": not the settings of a check: \"", limit, "\" is missing or no number"));
  return out;
}

/// The same program again, for one mesh.
BatchJob job_of(const LibraryMesh& mesh, const CheckArguments& a) {
  const std::string self = fs::read_symlink("/proc/self/exe").string();
  BatchJob out{mesh.key, {self, "check", "--one", mesh.file, "--json", "{json}", "--budget", text(a.check.budget)}};
  const auto add = [&](const std::string& name, const std::string& value) {
    out.arguments.push_back(name);
    out.arguments.push_back(value);
  };
  add("--body", a.check.body);
  add("--nodes", text(a.check.nodes));
  add("--young", text(a.check.young));
  add("--fill-holes", text(a.check.fill_holes));
  add("--until", a.check.until);
  add("--backend-timeout", text(a.check.backend_seconds));
  if (a.check.quick) out.arguments.emplace_back("--quick");
  if (a.no_wrap) out.arguments.emplace_back("--no-wrap");
  out.inputs = files_of(mesh.file);
  return out;
}

/// Where the rows of this part are, beside its settings.
std::string rows_file(const CheckArguments& a, const Shard& shard) {
  return shard.count == 1 ? a.out + "/rows.jsonl" : text(a.out, "/rows-", shard.index, "-of-", shard.count, ".jsonl");
}

/// Limits end a worker; they do not change what a row says that was not ended by them.
Json without_limits(Json settings) {
  for (const char* limit : kLimits) settings.erase(limit);
  return settings;
}

/// The keys in which two settings differ, with both values: "young" 1e5, not 2e5.
std::string differences(const Json& there, const Json& here) {
  std::vector<std::string> out;
  for (const auto& [key, value] : here.items())
    if (const Json its = there.value(key, Json()); its != value)
      out.push_back(text('"', key, "\" ", shown_json(its), ", not ", shown_json(value)));
  return out.empty() ? "a key more" : join(out);
}

/// Rows of other settings are no rows of this run; with other limits, those that met a limit are made again.
void agree_on_settings(const std::string& rows, const Json& settings, bool resume) {
  const std::string file = rows + ".settings.json";
  if (resume && fs::exists(file) && fs::exists(rows) && fs::file_size(rows) > 0) {
    const Json before = read_settings(rows);
    if (without_limits(before) != without_limits(settings))
      throw InputError(text("--resume: ", rows, " was made with other settings: ",
                            differences(without_limits(before), without_limits(settings)),
                            "; give the same (--timeout and --memory may differ), or another --out"));
    if (before != settings) forget_rows(rows, met_limit);
  }
  write_file_whole(file, json_text(settings) + "\n");
}

std::vector<Json> run_workers(const CheckArguments& a, const std::vector<LibraryMesh>& meshes,
                              const std::string& rows) {
  std::vector<BatchJob> jobs;
  for (const LibraryMesh& mesh : meshes) jobs.push_back(job_of(mesh, a));
  BatchOptions options{.file = rows, .resume = a.resume, .jobs = a.jobs, .limits = {}};
  options.limits = {.seconds = a.timeout,
                    .memory_bytes = static_cast<std::size_t>(a.memory_gb * 1073741824.0),
                    .stop = &stop_requested()};
  options.progress = progress_bar("checking", Piped::lines);
  if (a.resume && fs::exists(rows)) forget_rows(rows, was_killed);  // and looks at what is kept
  std::vector<Json> out = run_batch(jobs, options);
  // Killed from outside, by hand or by the system for want of memory: once more, and what is killed again says so.
  if (std::ranges::any_of(out, was_killed) && !stop_requested()) {
    forget_rows(rows, was_killed);
    options.resume = true;
    out = run_batch(jobs, options);
  }
  return out;
}

void print_summary(const Json& report, std::size_t meshes, const std::vector<std::string>& fresh,
                   const std::string& out) {
  const Json& s = report["summary"];
  std::cout << s["meshes"] << " meshes: " << s["pass"] << " pass, " << s["degraded"] << " degraded, " << s["fail"]
            << " fail\n";
  constexpr std::size_t kShown = 20;
  for (std::size_t i = 0; i < std::min(kShown, fresh.size()); ++i) {
    const auto row =
        std::ranges::find_if(report["rows"], [&](const Json& r) { return r["path"].get<std::string>() == fresh[i]; });
    std::cout << "  fail  " << fresh[i] << ": " << (*row)["stage"].get<std::string>() << ": "
              << (*row)["why"].get<std::string>() << "\n";
  }
  if (fresh.size() > kShown) std::cout << "  ... and " << fresh.size() - kShown << " more\n";
  const auto slow =
      std::ranges::count_if(report["rows"], [](const Json& r) { return r["real_time"]["keeps"] == "no"; });
  const auto large = std::ranges::count_if(report["rows"], [](const Json& r) {
    return r["real_time"]["told"].get<std::string>().find("--budget") != std::string::npos;
  });
  if (slow > 0)
    std::cout << "not in real time on this machine: " << slow << " of " << report["rows"].size()
              << " bodies; each row says which part is slow\n";
  if (large > 0)
    std::cout << "not for real time as they are: " << large << " surfaces over the budget; what was judged is a body "
              << "of fewer triangles (--budget)\n";
  if (report["rows"].size() < meshes)
    std::cout << "stopped: " << meshes - report["rows"].size() << " meshes are left; --resume goes on\n";
  std::cout << "results: " << out << "/report.json\n";
}

/// report.json, report.html.    @returns the exit code
int finish(const CheckArguments& a, std::vector<Json> rows, const Json& settings, std::size_t meshes) {
  Json outlines = Json::object();
  for (const Json& row : rows)
    if (row.contains("outline")) outlines[row["path"].get<std::string>()] = row["outline"];
  Json report = make_report(std::move(rows), settings);
  report["left"] = meshes - std::min(meshes, report["rows"].size());  // of a run that was stopped
  write_file_whole(a.out + "/report.json", json_text(report, 1) + "\n");
  write_file_whole(a.out + "/outlines.json", json_text(outlines) + "\n");
  write_json(a.json, json_text(report, 1) + "\n");
  const std::vector<std::string> fresh =
      new_failures(report, a.baseline.empty() ? Json() : read_check_report(a.baseline));
  print_summary(report, meshes, fresh, a.out);
  if (!a.no_report && !stop_requested()) write_check_page(a.out);
  return fresh.empty() && report["rows"].size() >= meshes ? 0 : 1;
}

std::vector<Json> to_report_rows(const std::vector<Json>& batch) {
  std::vector<Json> out;
  for (const Json& row : batch) out.push_back(report_row(row));
  return out;
}

int run_check(const CheckArguments& a) {
  const Shard shard = a.shard.empty() ? Shard{} : parse_shard(a.shard);
  const std::vector<LibraryMesh> meshes = part_of(find_meshes(a.paths), shard);
  if (!a.baseline.empty()) read_check_report(a.baseline);  // a wrong one is found before the work
  const OutputFolder folder(a.out, "--out " + a.out, {"report.json", "report.html", "outlines.json"},
                            shard.count > 1 ? FolderUse::shared : FolderUse::alone);
  const std::string rows = rows_file(a, shard);
  const Json settings = settings_of(a);
  agree_on_settings(rows, settings, a.resume);
  const std::vector<Json> batch = run_workers(a, meshes, rows);
  if (shard.count > 1) {  // the report is made from all of them
    std::cout << batch.size() << " of " << meshes.size() << " meshes of part " << shard.index << " of " << shard.count
              << ": " << rows << "\n";
    return batch.size() == meshes.size() ? 0 : 1;
  }
  return finish(a, to_report_rows(batch), settings, meshes.size());
}

/// Every file of rows in the folders, each mesh once.
int merge(const CheckArguments& a) {
  std::vector<std::string> files;
  for (const std::string& path : a.paths) {
    if (!fs::is_directory(path)) throw InputError(path + ": no such folder");
    for (const auto& entry : fs::directory_iterator(path))
      if (const std::string name = entry.path().filename().string();
          name.starts_with("rows") && name.ends_with(".jsonl"))
        files.push_back(entry.path().string());
  }
  std::ranges::sort(files);
  if (files.empty()) throw InputError(text(join(a.paths), ": no rows*.jsonl there"));
  std::map<std::string, Json> rows;
  Json settings;
  for (const std::string& file : files) {
    const Json its = read_settings(file);
    if (settings.is_null()) settings = its;
    if (without_limits(its) != without_limits(settings))
      throw InputError(text(file, " was made with other settings than ", files.front(), ": ",
                            differences(without_limits(its), without_limits(settings))));
    for (const char* limit : kLimits)
      settings[limit] = std::max(settings[limit].get<double>(), its[limit].get<double>());
    for (const Json& row : read_check_rows(file)) {
      const auto key = row["key"].get<std::string>();
      // One that was killed gives way to one that was not.
      if (const auto known = rows.find(key); known == rows.end() || was_killed(known->second)) rows[key] = row;
    }
  }
  const OutputFolder folder(a.out, "--out " + a.out, {"report.json", "report.html", "outlines.json"});
  std::vector<Json> out;
  for (const auto& [key, row] : rows) out.push_back(report_row(row));
  const std::size_t count = out.size();
  return finish(a, std::move(out), settings, count);
}

int run_one(CheckArguments& a) {
  // What a killed worker leaves behind lies in the folder that is removed after it.
  const fs::path folder = fs::absolute(a.json).parent_path();
  ::setenv("TMPDIR", folder.c_str(), 1);
  a.check.mesh = a.one;
  a.check.wrap = !a.no_wrap;
  a.check.stop = &stop_requested();
  check_one(a.check, a.json);
  return 0;
}

}  // namespace

void add_check_command(CLI::App& app, int& exit_code) {
  auto* command = app.add_subcommand("check", "whether each mesh of a library can be touched, and how well");
  const auto a = std::make_shared<CheckArguments>();
  command->add_option("PATH", a->paths, "mesh files and folders, or merge and folders of results to join");
  command->add_option("--out", a->out, "folder for the results")->capture_default_str();
  command->add_option("--jobs", a->jobs, "meshes at a time")->check(CLI::Range(1, 1024))->capture_default_str();
  command->add_option("--timeout", a->timeout, "limit for a mesh, s")->check(positive_number())->capture_default_str();
  command->add_option("--memory", a->memory_gb, "limit for a mesh, GB")
      ->check(positive_number())
      ->capture_default_str();
  command->add_flag("--resume", a->resume, "keep the rows that are there, and go on");
  command->add_option("--shard", a->shard, "I/N, part I of N of the meshes. merge makes the report");
  command->add_option("--baseline", a->baseline, "an older report.json, whose failures may fail again");
  command
      ->add_option("--body", a->check.body,
                   "body of a surface: a lattice, as in `kilotouch run`, or a mesh that fills it")
      ->check(CLI::IsMember({"lattice", "mesh"}))
      ->capture_default_str();
  command->add_option("--nodes", a->check.nodes, "nodes of a lattice, about")
      ->check(CLI::Range(50, kMostLatticeNodes))
      ->capture_default_str();
  command->add_option("--budget", a->check.budget, "most triangles of a mesh as body. Larger surfaces are decimated")
      ->check(CLI::Range(100, 10000000))
      ->capture_default_str();
  command->add_option("--young", a->check.young, "stiffness of the bodies, Pa, at a longest side of 0.1 m")
      ->check(number_within(1, 1e9))
      ->capture_default_str();
  command->add_option("--fill-holes", a->check.fill_holes, "close holes of at most this many edges first")
      ->check(CLI::Range(0, 1000000));
  command->add_flag("--no-wrap", a->no_wrap, "do not wrap surfaces that no tetrahedra fit into");
  command->add_flag("--quick", a->check.quick, "few shots, two places and one path, in a third of the time");
  std::vector<std::string> stages;
  for (const CheckStageEntry& stage : check_stages()) stages.emplace_back(stage.name);
  command->add_option("--until", a->check.until, "the last stage. shots tests surfaces only, solid their filling")
      ->check(CLI::IsMember(stages))
      ->capture_default_str();
  command->add_option("--backend-timeout", a->check.backend_seconds, "limit for each repair and tetrahedralizer, s")
      ->check(positive_number())
      ->capture_default_str();
  command->add_flag("--no-report", a->no_report, "no report.html");
  command->add_option("--one", a->one)->group("");  // the worker's part
  add_json_option(*command, a->json, "report.json");
  command->footer(
      "The exit code is 1 after a failure that the baseline does not have, and after a stop.\n"
      "Examples:\n  kilotouch check library/ --jobs 8 --out out\n"
      "  kilotouch check library/ --jobs 8 --out out --resume\n"
      "  kilotouch check merge part1 part2 --out whole");
  command->callback([a, &exit_code] {
    if (!a->one.empty()) {
      exit_code = run_one(*a);
      return;
    }
    if (a->paths.empty()) throw InputError("check: no PATH is given: a mesh file or a folder");
    const bool joins = a->paths.front() == "merge" && a->paths.size() > 1;
    if (joins) a->paths.erase(a->paths.begin());
    exit_code = joins ? merge(*a) : run_check(*a);
  });
}

}  // namespace kt
