#include "lab/chart/run_matrix.hpp"

#include <algorithm>
#include <filesystem>
#include <map>

#include "io/files/json_batch.hpp"
#include "io/files/output_file.hpp"
#include "io/files/shell_words.hpp"
#include "lab/chart/point.hpp"
#include "lab/study/reference.hpp"

namespace kt {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Rows = std::map<std::string, Json>;

/// A name that can be a folder's.
std::string slug(const std::string& name) {
  std::string out;
  for (const char c : name) out += std::isalnum(static_cast<unsigned char>(c)) || c == '.' ? c : '_';
  return out;
}

std::string absolute(const std::string& path) { return fs::absolute(path).lexically_normal().string(); }

/// `kilotouch run` of the scene with these settings, as words.
std::vector<std::string> run_words(const std::string& program, const ChartMatrix& matrix, const ChartBody& body,
                                   const std::vector<std::string>& set) {
  std::vector<std::string> out = {program, "run", absolute(matrix.scene)};
  for (const auto* list : {&body.set, &set})
    for (const std::string& setting : *list) out.insert(out.end(), {"--set", setting});
  return out;
}

/// As a user would type it.
std::string command_of(const ChartMatrix& matrix, const ChartBody& body, const std::vector<std::string>& set) {
  std::vector<std::string> words = run_words("kilotouch", matrix, body, set);
  words[2] = matrix.scene;
  return shell_words(words);
}

class MatrixRun {
 public:
  MatrixRun(const ChartMatrix& matrix, const ChartSettings& settings)
      : matrix_(matrix),
        settings_(settings),
        program_(fs::read_symlink("/proc/self/exe").string()),
        folder_(absolute(settings.out) + "/" + matrix.name) {
    make_inner_folder(folder_);
    make_inner_folder(folder_ + "/truth");
  }

  /// The truths first: the methods are compared with them.
  std::vector<BatchJob> truths() const { return matrix_.truth.empty() ? full_models() : better_meshes(); }

  std::vector<BatchJob> methods() const {
    std::vector<BatchJob> out;
    for (const ChartBody& body : matrix_.bodies)
      for (const ChartMethod& method : matrix_.methods) {
        auto words = run_words(program_, matrix_, body, method.set);
        words.insert(words.end(), {"--no-report", "--truth", truth_file(body), "--json", "{json}"});
        out.push_back({key_of(body, method), words, {truth_key(body)}, inputs(body)});
      }
    return out;
  }

  /// @param rows  of all matrices, by key
  Json result(const Rows& rows) const {
    Json out{{"name", matrix_.name}, {"title", matrix_.title}, {"scene", matrix_.scene}};
    out["references"] = matrix_.truth.empty() ? convergence(rows) : truth_of(rows);
    out["points"] = points(rows);
    mark_front(out["points"]);
    return out;
  }

 private:
  /// Files that a run on the body depends on.
  std::vector<std::string> inputs(const ChartBody& body) const {
    std::vector<std::string> out{absolute(matrix_.scene)};
    try {
      const Scene scene = load_scene(matrix_.scene, body.set);
      for (const std::string& mesh : {scene.object.mesh, scene.tool.mesh})
        if (!mesh.empty()) out.push_back(absolute(mesh));
    } catch (const InputError&) {  // the run tells
    }
    return out;
  }
  std::string truth_folder(const std::string& body, const std::string& what) const {
    return folder_ + "/truth/" + slug(body) + "_" + slug(what);
  }
  std::string named(const std::string& what) const { return matrix_.name + " | " + what; }
  std::string key_of(const ChartBody& body, const ChartMethod& method) const {
    return named(body.name + " | " + method.family + " | " + method.label);
  }
  std::string rate_key(const ChartBody& body, double hz) const { return named(body.name + ", " + rate_name(hz)); }
  std::string truth_key(const ChartBody& body) const {
    return matrix_.truth.empty() ? rate_key(body, settings_.reference_hz) : named(matrix_.truth.front().name);
  }
  double coarse_hz() const { return 0.5 * settings_.reference_hz; }
  static std::string rate_name(double hz) { return text(1e-3 * hz, " kHz"); }

  /// Each body's full model along the path, in fine steps and in steps of twice their length.
  std::vector<BatchJob> full_models() const {
    std::vector<BatchJob> out;
    for (const double hz : {settings_.reference_hz, coarse_hz()})
      for (const ChartBody& body : matrix_.bodies) {
        // The run that the reference accompanies only gives the path: the cheapest will do.
        auto words = run_words(program_, matrix_, body, {"local.reducer=condensed"});
        words.insert(words.end(), {"--reference", "--reference-rate", text(hz), "--no-report", "--force", "--out",
                                   truth_folder(body.name, rate_name(hz)), "--json", "{json}"});
        out.push_back({rate_key(body, hz), words, {}, inputs(body)});
      }
    return out;
  }

  std::vector<BatchJob> better_meshes() const {
    std::vector<BatchJob> out;
    for (const ChartBody& body : matrix_.truth) {
      auto words = run_words(program_, matrix_, body, matrix_.methods.front().set);
      words.insert(words.end(),
                   {"--no-report", "--force", "--out", truth_folder(body.name, "run"), "--json", "{json}"});
      out.push_back({named(body.name), words, {}, inputs(body)});
    }
    return out;
  }

  std::string truth_file(const ChartBody& body) const {
    if (matrix_.truth.empty()) return truth_folder(body.name, rate_name(settings_.reference_hz)) + "/reference.csv";
    return truth_folder(matrix_.truth.front().name, "run") + "/trace.csv";
  }

  /// How much the truth of each body changes when its steps are halved.
  Json convergence(const Rows& rows) const {
    Json out = Json::array();
    for (const ChartBody& body : matrix_.bodies) {
      Json one{{"body", body.name},
               {"what", "the full nonlinear body, same mesh, at " + rate_name(settings_.reference_hz)}};
      one["change_by_halving"] = nullptr;
      for (const double hz : {coarse_hz(), settings_.reference_hz})
        if (const auto row = rows.find(rate_key(body, hz)); row != rows.end() && row->second["outcome"] != "done")
          one["trouble"] = row->second["trouble"];
      const std::string coarse = truth_folder(body.name, rate_name(coarse_hz())) + "/reference.csv";
      if (!one.contains("trouble") && fs::exists(truth_file(body)) && fs::exists(coarse))
        one["change_by_halving"] =
            compare_forces(read_forces(coarse).force, read_forces(truth_file(body)).force).force_error;
      out.push_back(one);
    }
    return out;
  }

  Json truth_of(const Rows& rows) const {
    Json out = Json::array();
    for (const ChartBody& body : matrix_.truth) {
      const auto row = rows.find(named(body.name));
      if (row == rows.end()) continue;
      Json one{{"body", "all"}, {"what", body.name}, {"nodes", chart_point(row->second)["nodes"]}};
      if (row->second["outcome"] != "done")  // with a result: it ended, and doubts it
        one[row->second["result"].is_null() ? "trouble" : "doubt"] = row->second["trouble"];
      if (const Json& run = row->second["result"]; run.is_object()) one["last_force_n"] = run["force"]["max_n"];
      out.push_back(one);
    }
    return out;
  }

  Json points(const Rows& rows) const {
    Json out = Json::array();
    for (const ChartBody& body : matrix_.bodies)
      for (const ChartMethod& method : matrix_.methods) {
        const auto row = rows.find(key_of(body, method));
        if (row == rows.end()) continue;  // not run: stopped before
        Json point{
            {"body", body.name}, {"family", method.family}, {"label", method.label}, {"is_ours", method.is_ours}};
        point["command"] = command_of(matrix_, body, method.set);
        point.update(chart_point(row->second));
        if (const auto truth = rows.find(truth_key(body)); truth != rows.end() && truth->second["result"].is_null())
          point["trouble"] = text("no truth to compare with: ", truth->second["trouble"].get<std::string>());
        out.push_back(point);
      }
    return out;
  }

  /// In front of the others of the same truth.
  void mark_front(Json& points) const {
    const auto mark = [&](const std::string& body) {
      std::vector<double> cost, error;
      std::vector<Json*> of;
      const auto number = [](const Json& value) { return value.is_number() ? value.get<double>() : NAN; };
      for (Json& point : points) {
        if (!body.empty() && point["body"] != body) continue;
        of.push_back(&point);
        cost.push_back(number(point["tick_p50_us"]));
        error.push_back(number(point["force_error"]));
      }
      const std::vector<bool> front = pareto_front(cost, error);
      for (std::size_t i = 0; i < of.size(); ++i) (*of[i])["pareto"] = static_cast<bool>(front[i]);
    };
    if (!matrix_.truth.empty()) return mark("");
    for (const ChartBody& body : matrix_.bodies) mark(body.name);
  }

  const ChartMatrix& matrix_;
  const ChartSettings& settings_;
  std::string program_, folder_;
};

}  // namespace

Json run_matrices(const std::vector<ChartMatrix>& matrices, const ChartSettings& settings) {
  std::vector<MatrixRun> runs;
  for (const ChartMatrix& matrix : matrices) runs.emplace_back(matrix, settings);
  std::vector<BatchJob> jobs;
  const auto add = [&](std::vector<BatchJob> more) { std::ranges::move(more, std::back_inserter(jobs)); };
  // The longest first, so that no processor waits for it at the end: better meshes, full models, methods.
  for (const bool better_mesh : {true, false})
    for (std::size_t i = 0; i < runs.size(); ++i)
      if (matrices[i].truth.empty() != better_mesh) add(runs[i].truths());
  for (const MatrixRun& run : runs) add(run.methods());

  // Address space, not memory: threads' stacks and arenas reserve far more than they touch.
  const ChildLimits limits{.seconds = settings.seconds, .memory_bytes = std::size_t{32} << 30, .stop = settings.stop};
  Rows rows;
  for (Json& row : run_batch(jobs, {.file = settings.out + "/runs.jsonl",
                                   .resume = settings.resume,
                                   .jobs = settings.jobs,
                                   .limits = limits,
                                   .progress = settings.progress}))
    rows.emplace(row["key"].get<std::string>(), std::move(row));

  Json out = Json::array();
  for (const MatrixRun& run : runs) out.push_back(run.result(rows));
  return out;
}

}  // namespace kt
