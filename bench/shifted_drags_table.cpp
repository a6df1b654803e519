// How far forces are from the reference's over drags that differ by a part of an edge in where they go: a single drag
// decides little, since a contact that takes another branch changes it by more than most changes of the program do.
// Median and worst of the drags of each scene.
//   build/release/bench/shifted_drags_table [--scene NAME] [--model msd|fem] [--reducer NAME] [--drags N]
//     [--max-volume M3] [--duration S] [--reference-rate HZ] [--cache DIR]
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <string>

#include "haptics/session/metrics.hpp"
#include "haptics/session/session.hpp"
#include "io/files/output_file.hpp"
#include "io/scene/scene.hpp"
#include "lab/study/reference.hpp"

namespace kt {
namespace {

struct Options {
  std::string scene, model = "msd", reducer = "condensed", cache = "out/shifted_drags";
  int drags = 8;
  double max_volume = 0, duration = 0.9, reference_rate = 2000;
};

/// The scene's own drag carried aside, and along, by a part of an edge of the body.
Scene shifted(Scene scene, const Session& session, const Vec3& by) {
  scene.tool.path.press_drag.reset();
  scene.tool.path.waypoints.emplace();
  for (const TimedPoint& p : session.path()) scene.tool.path.waypoints->push_back({p.t, p.x + by});
  return scene;
}

Reference reference_of(const Session& session, const std::vector<PosePath>& path, const Options& options) {
  const std::uint64_t key = reference_key(session, path);
  char name[64];
  std::snprintf(name, sizeof name, "/%016llx_%g.csv", static_cast<unsigned long long>(key), options.reference_rate);
  const std::string file = options.cache + name;
  if (std::filesystem::exists(file)) return read_reference(file, key);
  const Reference out = run_reference(session, path, {.rate_hz = options.reference_rate});
  make_folder(options.cache);
  write_reference(file, out);
  return out;
}

void run(const std::string& name, const Options& options) {
  Scene scene = load_scene(text(KT_SOURCE_DIR "/scenes/", name, ".json"));
  scene.duration = options.duration;
  scene.object.model.type = options.model;
  scene.local.reducer = options.reducer;
  if (options.max_volume > 0) scene.object.tetrahedralize.emplace().max_volume = options.max_volume;
  const Session there(scene);
  const Surface surface = make_surface(there.model().mesh());
  double edge = 0;  // mean of the surface [m]
  for (const Triangle& t : surface.triangles)
    edge += (node(there.model().mesh().x, t[1]) - node(there.model().mesh().x, t[0])).norm() /
            static_cast<double>(surface.triangles.size());
  std::vector<double> errors, certified, took;
  for (int k = 0; k < options.drags; ++k) {
    const double part = static_cast<double>(k) / options.drags;
    Session session(shifted(scene, there, {part * edge, (k % 2 == 0 ? part : -part) * edge, 0}));
    const SessionResult result = session.run();
    const Reference reference = reference_of(session, tool_paths(result), options);
    errors.push_back(100 * compare_forces(result.tools[0].model_force, reference).force_error);
    certified.push_back(100 * result.certified_error);
    took.push_back(percentile(result.refresh.cpu_ms, 0.5));
    std::printf("  %-12s %-4s %6d %-10s %d | force error %6.3f %%  certified %6.2f %%  refresh %6.1f ms\n",
                name.c_str(), options.model.c_str(), session.model().mesh().num_nodes(), result.reducer_name.c_str(), k,
                errors.back(), certified.back(), took.back());
    std::fflush(stdout);
  }
  std::printf("%-12s %-4s %-10s | force error, median %6.3f %%  worst %6.3f %% | certified, median %6.2f %%\n",
              name.c_str(), options.model.c_str(), options.reducer.c_str(), percentile(errors, 0.5),
              percentile(errors, 1), percentile(certified, 0.5));
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  kt::Options options;
  CLI::App app;
  app.add_option("--scene", options.scene);
  app.add_option("--model", options.model);
  app.add_option("--reducer", options.reducer);
  app.add_option("--drags", options.drags);
  app.add_option("--max-volume", options.max_volume);
  app.add_option("--duration", options.duration);
  app.add_option("--reference-rate", options.reference_rate);
  app.add_option("--cache", options.cache);
  CLI11_PARSE(app, argc, argv);
  for (const char* scene : {"organ_drag", "slab_drag"})
    if (options.scene.empty() || options.scene == scene) kt::run(scene, options);
  return 0;
}
