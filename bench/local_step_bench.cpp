// Cost of one haptic tick in steady sliding contact; scenes/slab_drag.json, 2560 or 10240 surface triangles, wall
// reducer.
//   ./build/release/bench/local_step_bench --benchmark_counters_tabular=true
//   ./build/release/bench/local_step_bench --benchmark_filter='Tick/coarse' --benchmark_format=json
// TickBlock rows: the same over a block of 3703 nodes, each reducer.
// Tick rows: CPU time of the tick's thread; p50_us, p999_us and max_us over a drag with its refreshes.
#include <benchmark/benchmark.h>

#include "bench/steady_drag.hpp"
#include "core/base/cpu_time.hpp"
#include "haptics/session/metrics.hpp"

namespace kt {
namespace {

constexpr int kTicks = 6000, kBlockTicks = 3000;  // over a block refreshes cost more than ticks

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

void tick_scene(benchmark::State& state, const Scene& scene) {
  SteadyDrag drag(scene);
  std::vector<double> us;
  int contacts = 0;
  for (auto _ : state) {
    drag.refresh_when_due();
    const double start = thread_time_us();
    const LocalFrame frame = drag.step();
    us.push_back(thread_time_us() - start);
    contacts += frame.contacts;
    state.SetIterationTime(1e-6 * us.back());
  }
  state.counters["p50_us"] = percentile(us, 0.5);
  state.counters["p999_us"] = percentile(us, 0.999);
  state.counters["max_us"] = percentile(us, 1);
  state.counters["dof"] = drag.local.model().model.dof();
  state.counters["patch_vertices"] = drag.local.model().model.patch.num_vertices();
  state.counters["contacts"] = static_cast<double>(contacts) / static_cast<double>(us.size());
}

void tick(benchmark::State& state, const Setup& setup) {
  tick_scene(state, slab_drag(setup.mesh, setup.shape, setup.rings));
}

void tick_block(benchmark::State& state, const NamedReducer& r) {
  tick_scene(state, block_drag(kBlocks[1], r.reducer, r.rings));
}

const int kRegistered = [] {
  for (const NamedReducer& r : tick_reducers())
    benchmark::RegisterBenchmark((std::string("TickBlock/") + r.name).c_str(), tick_block, r)
        ->Iterations(kBlockTicks)
        ->UseManualTime()
        ->Unit(benchmark::kMicrosecond);
  for (const Setup& s : kSetups)
    benchmark::RegisterBenchmark((std::string("Tick/") + s.name).c_str(), tick, s)
        ->Iterations(kTicks)
        ->UseManualTime()
        ->Unit(benchmark::kMicrosecond);
  return 0;
}();

}  // namespace
}  // namespace kt
