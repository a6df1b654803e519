#include "lab/check/rows.hpp"

#include <algorithm>
#include <filesystem>

#include "core/base/error.hpp"
#include "io/files/json_batch.hpp"
#include "io/files/json_file.hpp"
#include "io/files/output_file.hpp"
#include "lab/check/verdict.hpp"
#include "lab/check/worker.hpp"

namespace kt {
namespace {

using Json = nlohmann::ordered_json;

/// What ended the worker, in a word and without what differs from run to run.
std::string end_of(const Json& batch_row) {
  const auto outcome = batch_row["outcome"].get<std::string>(), trouble = batch_row["trouble"].get<std::string>();
  return outcome + ": " + trouble.substr(0, trouble.find(':'));
}

void add_end(const Json& batch_row, Json& stages) {
  const Json& result = batch_row["result"];
  StageResult end;
  end.name = result.is_object() ? result.value("running", "") : "start";
  if (end.name.empty()) end.name = "end";
  end.lower(Verdict::fail, end_of(batch_row));
  stages.push_back(to_json(end));
}

/// Whether the bodies kept up with the wall clock, the slower one's words; of a decimated surface, that it was not
/// asked.
Json real_time_of(const Json& stages, int triangles) {
  Json out{{"keeps", nullptr}, {"told", ""}};
  const auto stage = [&](const char* name) {
    return std::ranges::find_if(stages, [&](const Json& s) { return s["name"] == name; });
  };
  if (const auto drag = stage("drag"); drag != stages.end())
    for (const auto& [model, times] : drag->at("times").items()) {
      if (!times.is_object() || !times.contains("real_time")) continue;
      const Json& its = times["real_time"];
      const bool is_worse = out["keeps"].is_null() || its["keeps"] == "no" || out["keeps"] == "yes";
      if (!is_worse) continue;
      out["keeps"] = its["keeps"];
      out["told"] = model + ": " + its["told"].get<std::string>();
    }
  if (const auto solid = stage("solid"); solid != stages.end() && solid->at("figures").contains("decimated"))
    out["told"] = out["told"].get<std::string>() + (out["told"] == "" ? "" : "; ") +
                  text("the surface of ", triangles, " triangles is not for real time: that is the body of fewer ",
                       "triangles that was made of it (--budget)");
  return out;
}

}  // namespace

namespace {

/// A value that is there has the kind that the worker gives it; else what is wrong with it.
std::string kind_problem(const Json& of, const char* key, bool (Json::*kind)() const noexcept, const char* name) {
  if (!of.contains(key)) return {};
  return (of[key].*kind)() ? "" : text("\"", key, "\" is ", shown_json(of[key]), ", must be ", name);
}

std::string stage_problem(const Json& stage) {
  if (!stage.is_object()) return text("a stage is ", shown_json(stage), ", must be a group");
  for (const char* key : {"name", "verdict", "why"})
    if (!stage.contains(key) || !stage[key].is_string()) return text("a stage's \"", key, "\" is missing or no text");
  const auto is_named = [&](const CheckStageEntry& entry) { return stage["name"] == entry.name; };
  const bool is_of_batch = stage["name"] == "start" || stage["name"] == "end";
  if (!is_of_batch && std::ranges::none_of(check_stages(), is_named))
    return text("there is no stage ", shown_json(stage["name"]));
  verdict_named(stage["verdict"].get<std::string>());
  for (const char* key : {"figures", "times"})
    if (auto why = kind_problem(stage, key, &Json::is_object, "a group"); !why.empty()) return why;
  if (!stage.contains("where")) return {};
  const Json& where = stage["where"];
  const auto is_coordinate = [](const Json& c) { return c.is_number() || c.is_null(); };
  return where.is_array() && where.size() == 3 && std::ranges::all_of(where, is_coordinate)
             ? ""
             : text("a stage's \"where\" is ", shown_json(where), ", must be three numbers");
}

std::string outline_problem(const Json& outline) {
  if (!outline.is_object()) return "\"outline\" is no group";
  const auto is_list = [&](const char* key) {
    return outline.contains(key) && outline[key].is_array() &&
           std::ranges::all_of(outline[key], [](const Json& v) { return v.is_number(); });
  };
  const bool is_whole = is_list("x") && is_list("t") && is_list("min") && outline["min"].size() == 3 &&
                        outline.contains("size") && outline["size"].is_number();
  return is_whole ? "" : "\"outline\" has not the lists x, t, min and the number size";
}

/// @param result  what a worker wrote, or null
std::string result_problem(const Json& result) {
  if (result.is_null()) return {};
  if (!result.is_object()) return text("\"result\" is ", shown_json(result), ", must be a group or null");
  for (const std::string& why : {kind_problem(result, "running", &Json::is_string, "a text"),
                                 kind_problem(result, "triangles", &Json::is_number_integer, "a whole number"),
                                 kind_problem(result, "times", &Json::is_object, "a group"),
                                 kind_problem(result, "stages", &Json::is_array, "a list")})
    if (!why.empty()) return why;
  if (result.contains("times"))
    for (const auto& [key, value] : result["times"].items())
      if (!value.is_number()) return text("the time \"", key, "\" is no number");
  if (result.contains("stages"))
    for (const Json& stage : result["stages"])
      if (auto why = stage_problem(stage); !why.empty()) return why;
  return result.contains("outline") ? outline_problem(result["outline"]) : "";
}

}  // namespace

std::vector<Json> read_check_rows(const std::string& file) {
  std::vector<Json> rows = read_batch(file);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::string why;
    try {
      why = result_problem(rows[i]["result"]);
    } catch (const InputError& e) {
      why = e.what();
    }
    if (!why.empty()) throw InputError(text(file, ", line ", i + 1, ": not a row of a check: ", why));
  }
  return rows;
}

Json read_check_report(const std::string& file) {
  if (!std::filesystem::exists(file)) throw InputError(file + ": cannot be read: no such file");
  Json report = read_json_file(file);
  const auto fail = [&](const std::string& why) {
    throw InputError(text(file, ": not a report of a check (report.json): ", why));
  };
  if (!report.is_object() || !report.contains("rows") || !report["rows"].is_array()) fail("it has no list \"rows\"");
  const Json& rows = report["rows"];
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (const char* key : {"path", "verdict"})
      if (!rows[i].is_object() || !rows[i].contains(key) || !rows[i][key].is_string())
        fail(text("rows[", i, "] has no \"", key, "\""));
  return report;
}

Json report_row(const Json& batch_row) {
  const Json& result = batch_row["result"];
  Json stages = result.is_object() && result.contains("stages") ? result["stages"] : Json::array();
  const bool ended = batch_row["outcome"] == "done" && result.is_object() && result.value("running", "?").empty();
  if (!ended) add_end(batch_row, stages);

  Verdict verdict = Verdict::pass;
  for (const Json& s : stages) verdict = worse(verdict, verdict_named(s["verdict"]));
  Json out{{"path", batch_row["key"]}, {"verdict", name_of(verdict)}, {"stage", ""}, {"why", ""}};
  if (verdict != Verdict::pass) {
    const auto first = std::ranges::find_if(stages, [&](const Json& s) { return s["verdict"] == name_of(verdict); });
    out["stage"] = (*first)["name"];
    out["why"] = (*first)["why"];
    if (first->contains("where")) out["where"] = (*first)["where"];
  }
  out["triangles"] = result.is_object() ? result.value("triangles", 0) : 0;
  out["real_time"] = real_time_of(stages, out["triangles"].get<int>());
  out["stages"] = std::move(stages);
  out["times"] = result.is_object() && result.contains("times") ? result["times"] : Json::object();
  out["times"]["wall_s"] = batch_row["seconds"];
  if (result.is_object() && result.contains("outline")) out["outline"] = result["outline"];
  return out;
}

bool was_killed(const Json& batch_row) {
  return batch_row["outcome"] == "crash" && batch_row["trouble"].get<std::string>().starts_with("crashed (Killed)");
}

bool met_limit(const Json& batch_row) {
  const Json& result = batch_row["result"];
  if (batch_row["outcome"] == "timeout" || batch_row["outcome"] == "memory") return true;
  return result.is_object() && result.contains("stages") && std::ranges::any_of(result["stages"], [](const Json& s) {
           return s["why"].get<std::string>().find(kNoMemory) != std::string::npos;
         });
}

int forget_rows(const std::string& file, bool (*are_forgotten)(const Json& batch_row)) {
  std::string kept;
  int forgotten = 0;
  for (const Json& row : read_check_rows(file)) {
    if (are_forgotten(row))
      ++forgotten;
    else
      kept += json_text(row) + "\n";
  }
  if (forgotten > 0) write_file_whole(file, kept);
  return forgotten;
}

Json make_report(std::vector<Json> rows, const Json& settings) {
  std::ranges::sort(rows, {}, [](const Json& row) { return row["path"].get<std::string>(); });
  Json summary{{"meshes", rows.size()}, {"pass", 0}, {"degraded", 0}, {"fail", 0}, {"triangles", 0}};
  Json by_stage = Json::object();
  double cpu = 0, wall = 0;
  long triangles = 0;
  for (Json& row : rows) {
    row.erase("outline");
    const auto verdict = row["verdict"].get<std::string>();
    summary[verdict] = summary[verdict].get<int>() + 1;
    if (verdict == "fail") {
      const auto stage = row["stage"].get<std::string>();
      by_stage[stage] = by_stage.value(stage, 0) + 1;
    }
    triangles += row["triangles"].get<long>();
    cpu += row["times"].value("cpu_s", 0.0);
    wall += row["times"].value("wall_s", 0.0);
  }
  summary["triangles"] = triangles;
  summary["failed_in"] = by_stage;
  Json times{{"cpu_s", cpu}, {"worker_s", wall}};
  times["cpu_s_per_100000_triangles"] = triangles > 0 ? Json(cpu * 1e5 / static_cast<double>(triangles)) : Json();
  return {{"kilotouch", KT_VERSION}, {"settings", settings}, {"summary", summary}, {"times", times}, {"rows", rows}};
}

std::vector<std::string> new_failures(const Json& report, const Json& baseline) {
  std::vector<std::string> known, out;
  if (baseline.is_object() && baseline.contains("rows"))
    for (const Json& row : baseline["rows"])
      if (row["verdict"] == "fail") known.push_back(row["path"]);
  std::ranges::sort(known);
  for (const Json& row : report["rows"])
    if (row["verdict"] == "fail" && !std::ranges::binary_search(known, row["path"].get<std::string>()))
      out.push_back(row["path"]);
  return out;
}

}  // namespace kt
