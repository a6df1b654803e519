#include "lab/check/worker.hpp"

#include <signal.h>
#include <sys/resource.h>

#include <new>

#include "core/base/cpu_time.hpp"
#include "core/base/error.hpp"
#include "core/base/parallel.hpp"
#include "io/files/child_process.hpp"
#include "io/files/output_file.hpp"
#include "lab/check/outline.hpp"

namespace kt {
namespace {

using Json = nlohmann::ordered_json;

constexpr CheckStageEntry kStages[] = {
    {"load", check_load, false, false},     {"doctor", check_doctor, false, false},
    {"repair", check_repair, false, false}, {"queries", check_queries, false, false},
    {"shots", check_shots, false, false},   {"solid", check_solid, false, false},
    {"models", check_models, false, false}, {"local_models", check_local_models, true, true},
    {"press", check_press, true, true},     {"drag", check_drag, true, true},
    {"energy", check_energy, true, false},
};

double cpu_seconds() {
  rusage children{};
  getrusage(RUSAGE_CHILDREN, &children);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return 1e-3 * process_time_ms() + seconds(children.ru_utime) + seconds(children.ru_stime);
}

double peak_mb() {
  rusage own{};
  getrusage(RUSAGE_SELF, &own);
  return static_cast<double>(own.ru_maxrss) / 1024;
}

StageResult run_stage(const CheckStageEntry& entry, MeshWork& work) {
  StageResult out;
  out.name = entry.name;
  if (entry.needs_body && work.bodies.empty()) {
    out.lower(Verdict::skipped, "there is no body");
    return out;
  }
  if (entry.needs_spots && work.spots.empty()) {
    out.lower(Verdict::skipped, "there is no place to touch");
    return out;
  }
  const double start = cpu_seconds();
  try {
    entry.run(work, out);
  } catch (const std::bad_alloc&) {
    out.lower(Verdict::fail, kNoMemory);
  } catch (const ChildKilled&) {
    // What would come of it is no fact of the mesh. The parent tries a worker that was killed once more.
    ::raise(SIGKILL);
  } catch (const std::exception& e) {
    out.lower(Verdict::fail, e.what());
  }
  out.times["cpu_s"] = cpu_seconds() - start;
  return out;
}

/// After these a failure leaves nothing to go on with.
bool is_needed_by_all(const std::string& stage) { return stage == "load" || stage == "repair" || stage == "solid"; }

}  // namespace

std::span<const CheckStageEntry> check_stages() { return kStages; }

void check_one(const CheckOptions& options, const std::string& json_file) {
  MeshWork work;
  work.options = options;
  Json row{{"stages", Json::array()}, {"running", ""}};
  const auto write = [&](const std::string& running) {
    row["running"] = running;
    row["times"] = {{"cpu_s", cpu_seconds()}, {"peak_mb", peak_mb()}};
    write_file_whole(json_file, row.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
  };
  // Meshes run side by side, each on one core: then times compare, and no thread waits for another's.
  with_threads(1, [&] {
    std::string over;  // why later stages are not tried
    for (const CheckStageEntry& entry : kStages) {
      write(entry.name);
      StageResult stage;
      if (over.empty()) {
        stage = run_stage(entry, work);
      } else {
        stage.name = entry.name;
        stage.lower(Verdict::skipped, over);
      }
      if (stage.verdict == Verdict::fail && is_needed_by_all(stage.name)) over = text("after ", stage.name, " failed");
      row["stages"].push_back(to_json(stage));
      if (stage.name == "load") row["triangles"] = work.input.triangles.size();
      if (stage.name == "doctor" && over.empty()) row["outline"] = outline(work.input);
      if (over.empty() && stage.name == options.until) over = "not asked for";
      if (options.stop && options.stop->load()) throw RunError("interrupted");
    }
  });
  write("");
}

}  // namespace kt
