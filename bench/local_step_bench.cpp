// Cost of one haptic tick in steady sliding contact; scenes/slab_drag.json, 2560 or 10240 surface triangles, wall
// reducer.
//   ./build/release/bench/local_step_bench --benchmark_counters_tabular=true
//   ./build/release/bench/local_step_bench --benchmark_filter='Tick/coarse' --benchmark_format=json
// TickBlock rows: the same over a block of 3703 nodes, each reducer.
// p50_us, p999_us, max_us: CPU time of the tick's thread over the ticks of a drag.
#include <benchmark/benchmark.h>

#include <filesystem>
#include <vector>

#include "core/base/percentile.hpp"
#include "haptics/session/session.hpp"
#include "io/files/output_file.hpp"
#include "io/mesh/mesh_formats.hpp"

namespace kt {
namespace {

constexpr double kPressed = 0.2;  // [s]

/// scenes/slab_drag.json with another mesh, tool and number of rings, dragged to and fro over the middle of the slab
/// (0.1 x 0.1 x 0.03 m).
Scene slab_drag(const std::string& mesh, const std::string& shape, int rings) {
  Scene scene;
  scene.object.mesh = KT_SOURCE_DIR "/meshes/" + mesh;
  scene.tool.shape = shape;
  scene.local.rings = rings;
  const bool is_point =
      shape == "point";  // it makes a sharp dent: deeper than 3 mm tetrahedra turn inside out under it
  const double top = 0.03 + (is_point ? 0 : scene.tool.radius), z = top - (is_point ? 0.002 : 0.004);
  std::vector<Waypoint> path{{0, {0.03, 0.05, top + 0.002}}, {kPressed, {0.03, 0.05, z}}};
  for (int i = 1; i <= 20; ++i) path.push_back({kPressed + 0.8 * i, {i % 2 ? 0.07 : 0.03, 0.05, z}});
  scene.tool.path.press_drag.reset();
  scene.tool.path.waypoints = path;
  scene.local.reducer = "wall";
  scene.local.refine = "off";
  if (!KT_WITH_EMBREE) scene.collision.backend = "brute_force";
  return scene;
}

/// The same drag, a sphere 2 mm deep, over a neo-Hookean block as large as the slab. Its mesh is written to the
/// temporary folder: a scene names a file.
Scene block_drag(const std::string& reducer, int rings) {
  constexpr int kAcross = 22, kUp = 6;
  Mesh mesh = kuhn_block(kAcross, kAcross, kUp, 0.1 / kAcross);
  for (Eigen::Index i = 2; i < mesh.x.size(); i += 3) mesh.x[i] *= 0.03 / (0.1 / kAcross * kUp);
  const auto file = std::filesystem::temp_directory_path() / text("kilotouch_block_", mesh.num_nodes(), ".msh");
  write_file_whole(file.string(), write_msh(mesh));
  Scene scene = slab_drag("", "sphere", rings);
  scene.object.mesh = file.string();
  scene.object.model.type = "fem";
  scene.local.reducer = reducer;
  for (Waypoint& w : *scene.tool.path.waypoints)
    if (w.t >= kPressed) w.position.z() += 0.002;
  return scene;
}

struct NamedReducer {
  const char *name, *reducer;
  int rings;
};
constexpr NamedReducer kReducers[] = {{"wall1", "wall", 1},    {"wall3", "wall", 3},  {"condensed", "condensed", 1},
                                      {"krylov", "krylov", 1}, {"modal", "modal", 1}, {"auto", "auto", 1}};

struct Setup {
  const char *name, *mesh, *shape;
  int rings;
};
constexpr Setup kSetups[] = {
    {"coarse/point/1_ring", "slab_coarse.off", "point", 1},   {"coarse/point/3_rings", "slab_coarse.off", "point", 3},
    {"coarse/sphere/1_ring", "slab_coarse.off", "sphere", 1}, {"coarse/sphere/3_rings", "slab_coarse.off", "sphere", 3},
    {"fine/point/1_ring", "slab_fine.off", "point", 1},       {"fine/point/3_rings", "slab_fine.off", "point", 3},
    {"fine/sphere/1_ring", "slab_fine.off", "sphere", 1},     {"fine/sphere/3_rings", "slab_fine.off", "sphere", 3},
};

/// Ticks of a run in lockstep, from where the tool is pressed in on.
void tick_scene(benchmark::State& state, Scene scene, int ticks) {
  constexpr double kSettled = kPressed + 0.1;  // [s]
  scene.duration = kSettled + ticks / scene.local.rate_hz;
  scene.link.type = "lockstep";
  Session session(scene);
  SessionResult result;
  for (auto _ : state) result = session.run();
  std::vector<double> us;
  double contacts = 0;
  for (std::size_t i = 0; i < result.step_us.size(); ++i) {
    const LocalFrame& frame = result.tools[0].frames[i];
    if (frame.t < kSettled) continue;
    us.push_back(result.step_us[i]);
    contacts += frame.contacts;
  }
  state.counters["p50_us"] = percentile(us, 0.5);
  state.counters["p999_us"] = percentile(us, 0.999);
  state.counters["max_us"] = percentile(us, 1);
  state.counters["dof"] = result.last_dof;
  state.counters["patch_vertices"] = result.last_patch_vertices;
  state.counters["contacts"] = contacts / static_cast<double>(us.size());
}

void tick(benchmark::State& state, const Setup& setup) {
  tick_scene(state, slab_drag(setup.mesh, setup.shape, setup.rings), 6000);
}

/// Fewer ticks, since refreshes cost more than they do.
void tick_block(benchmark::State& state, const NamedReducer& r) {
  tick_scene(state, block_drag(r.reducer, r.rings), 3000);
}

const int kRegistered = [] {
  for (const NamedReducer& r : kReducers)
    benchmark::RegisterBenchmark((std::string("TickBlock/") + r.name).c_str(), tick_block, r)->Iterations(1);
  for (const Setup& s : kSetups)
    benchmark::RegisterBenchmark((std::string("Tick/") + s.name).c_str(), tick, s)->Iterations(1);
  return 0;
}();

}  // namespace
}  // namespace kt
