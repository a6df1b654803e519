// What a refresh takes by stage, over the press and drag of scenes/organ_drag.json on bodies of some sizes, springs and
// neo-Hookean elements: medians [ms] of the clock by stage, and of the processor's time in all with its 90th
// percentile, its largest and what was predicted of it. The first refresh, which sets the run up, is left out.
//   build/release/bench/refresh_table [--reducer NAME] [--model msd|fem] [--nodes ABOUT] [--duration S] [--thread 1]
//     [--stages 1] [--threads N]
#include <CLI/CLI.hpp>
#include <cstdio>
#include <string>

#include "core/base/parallel.hpp"
#include "core/base/stages.hpp"
#include "haptics/session/metrics.hpp"
#include "haptics/session/session.hpp"
#include "io/scene/scene.hpp"

namespace kt {
namespace {

struct Options {
  std::string reducer = "condensed", model;
  int nodes = 0;
  double duration = 0.9;
  bool thread = false, stages = false;
};

/// Of each stage over the refreshes after the first three: median, 90th percentile and mean of those with it, and in
/// how many it was.
void print_stages(const StageTimes& times) {
  std::map<std::string, std::vector<double>> all;
  std::vector<std::string> order;
  for (std::size_t i = 3; i < times.rows().size(); ++i)
    for (const auto& [name, ms] : times.rows()[i]) {
      if (all.count(name) == 0) order.push_back(name);
      all[name].push_back(ms);
    }
  std::sort(order.begin(), order.end());
  for (const std::string& name : order) {
    double sum = 0;
    for (double ms : all[name]) sum += ms;
    std::printf("      %-24s %7.2f %7.2f  all %8.1f in %3zu of %zu\n", name.c_str(), percentile(all[name], 0.5),
                percentile(all[name], 0.9), sum / static_cast<double>(times.rows().size() - 3), all[name].size(),
                times.rows().size() - 3);
  }
}

/// The organ's surface, and the largest tetrahedron below it [m^3].
struct SizedBody {
  int about;
  std::optional<double> max_volume;
};
const SizedBody kBodies[] = {{900, 2e-7}, {1650, {}}, {3000, 2.2e-8}, {10000, 5e-9}};

void run(const SizedBody& body, const std::string& model, const Options& options) {
  Scene scene = load_scene(KT_SOURCE_DIR "/scenes/organ_drag.json");
  scene.duration = options.duration;
  scene.object.model.type = model;
  if (body.max_volume) scene.object.tetrahedralize.emplace().max_volume = body.max_volume;
  scene.local.reducer = options.reducer;
  if (options.thread) scene.link.type = "thread";
  Session session(scene);
  StageTimes times;
  if (options.stages) StageTimes::asked() = &times;
  const SessionResult result = session.run();
  StageTimes::asked() = nullptr;
  const auto later = [](std::vector<double> ms) {
    ms.erase(ms.begin(), ms.begin() + std::min<std::ptrdiff_t>(2, static_cast<std::ptrdiff_t>(ms.size())));
    return ms;
  };
  const std::vector<double> cpu = later(result.refresh.cpu_ms);
  double predicted = 0;
  for (const ReducerCandidate& c : result.reducer_candidates)
    if (c.name == result.reducer_name) predicted = c.refresh_ms;
  const auto patch = result.last_patch_vertices;
  std::printf("%-4s %6d %-22s %4d %4d | %6.1f", model.c_str(), session.model().mesh().num_nodes(),
              result.reducer_name.c_str(), result.last_dof, patch, percentile(later(result.refresh.global_ms), 0.5));
  for (const auto& part : result.refresh.parts_ms) std::printf(" %6.1f", percentile(later(part.second), 0.5));
  std::printf(" | %6.1f %6.1f %6.1f %6.2f %9.1f | %4.1f\n", percentile(cpu, 0.5), percentile(cpu, 0.9),
              percentile(cpu, 1), percentile(cpu, 0.9) / percentile(cpu, 0.5), predicted,
              static_cast<double>(result.refreshes.size()) / options.duration);
  if (options.stages) print_stages(times);
  std::fflush(stdout);
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  kt::Options options;
  int threads = 0;
  CLI::App app;
  app.add_option("--reducer", options.reducer);
  app.add_option("--model", options.model);
  app.add_option("--nodes", options.nodes);
  app.add_option("--duration", options.duration);
  app.add_option("--stages", options.stages);
  app.add_option("--threads", threads);
  app.add_option("--thread", options.thread);
  CLI11_PARSE(app, argc, argv);
  std::printf(
      "body  nodes reducer                 dof vert | global linear reduce certif prepar |    cpu    p90    max  "
      "p90/p50 "
      "predicted |  Hz\n");
  for (const char* model : {"msd", "fem"})
    for (const kt::SizedBody& body : kt::kBodies)
      if ((options.model.empty() || options.model == model) && (options.nodes == 0 || options.nodes == body.about)) {
        if (threads == 0)
          kt::run(body, model, options);
        else
          kt::with_threads(threads, [&] { kt::run(body, model, options); });
      }
  return 0;
}
