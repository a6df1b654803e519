// Cost of the slow side: linearize, reduce, prepare, and the global step; scenes/slab_drag.json.
//   ./build/release/bench/refresh_bench --benchmark_counters_tabular=true
#include <benchmark/benchmark.h>

#include "bench/steady_drag.hpp"
#include "core/global_simulation.hpp"
#include "core/tangent_model.hpp"

namespace kt {
namespace {

constexpr const char* kMeshes[] = {"slab_coarse.off", "slab_fine.off"};

/// A body under the tool, in the middle of a drag. Argument 0: the mesh; argument 1: rings.
SteadyDrag make_drag(const benchmark::State& state) {
  return SteadyDrag(slab_drag(kMeshes[state.range(0)], "sphere", static_cast<int>(state.range(1))));
}

ContactSite site_of(const SteadyDrag& drag) {
  const PreparedLocalModel& m = drag.local.model();
  const Contact& held = m.state.anchors.contacts[0];
  return {drag.sweep().x_t0 - drag.tool.radius * held.normal, m.model.patch.global_triangle[held.triangle],
          1.5 * drag.tool.radius + path_speed(drag.session.path()) / drag.session.scene().global.rate_hz};
}

void report_size(benchmark::State& state, const SteadyDrag& drag) {
  state.counters["nodes"] = drag.session.model().mesh().num_nodes();
  state.counters["dof"] = drag.local.model().model.dof();
}

void BM_Linearize(benchmark::State& state) {
  const SteadyDrag drag = make_drag(state);
  for (auto _ : state) benchmark::DoNotOptimize(linearize(drag.session.model(), drag.refresher.state()));
  report_size(state, drag);
}

void BM_Reduce(benchmark::State& state) {
  const SteadyDrag drag = make_drag(state);
  const State& body = drag.refresher.state();
  const TangentModel tangent = linearize(drag.session.model(), body);
  const ReduceFn reduce = find_reducer("wall");
  const ReduceOptions options{static_cast<int>(state.range(1))};
  for (auto _ : state)
    benchmark::DoNotOptimize(reduce(tangent, make_patch(drag.surface, body.x, site_of(drag)), site_of(drag), options));
  report_size(state, drag);
}

void BM_Prepare(benchmark::State& state) {
  const SteadyDrag drag = make_drag(state);
  for (auto _ : state)
    benchmark::DoNotOptimize(prepare(drag.local.model().model, LocalScheme::implicit_euler, Metric::implicit,
                                     drag.local.h(), drag.session.scene().collision.backend,
                                     drag.session.model().mesh().num_nodes(),
                                     static_cast<int>(drag.surface.triangles.size())));
  report_size(state, drag);
}

void BM_GlobalStep(benchmark::State& state) {
  const SteadyDrag drag = make_drag(state);
  const double step = 1 / drag.session.scene().global.rate_hz;
  GlobalSimulation global(drag.session.model(), make_integrator("implicit_euler"), step);
  for (auto _ : state) global.advance(global.state().t + step, {});
  report_size(state, drag);
}

BENCHMARK(BM_Linearize)->ArgNames({"mesh", "rings"})->Args({0, 1})->Args({1, 1})->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Reduce)->ArgNames({"mesh", "rings"})->ArgsProduct({{0, 1}, {1, 3}})->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Prepare)->ArgNames({"mesh", "rings"})->ArgsProduct({{0, 1}, {1, 3}})->Unit(benchmark::kMillisecond);
BENCHMARK(BM_GlobalStep)->ArgNames({"mesh", "rings"})->Args({0, 1})->Args({1, 1})->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace kt
