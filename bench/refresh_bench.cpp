// Cost of the slow side: refreshes of a drag as they follow each other at 30 Hz, for each reducer, on blocks of 1280,
// 3703 and 10240 nodes; medians [ms] of the whole and of its parts, wall clock; cpu_ms: of the global step too, and of
// all threads.
//   ./build/release/bench/refresh_bench --benchmark_counters_tabular=true
#include <benchmark/benchmark.h>

#include <chrono>
#include <ctime>

#include "bench/steady_drag.hpp"
#include "core/body/tangent_model.hpp"
#include "haptics/session/metrics.hpp"

namespace kt {
namespace {

constexpr int kRefreshes = 15;

template <typename F>
double milliseconds_of(const F& run) {
  const auto start = std::chrono::steady_clock::now();
  run();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

void refreshes(benchmark::State& state, const BlockCells& block, const NamedReducer& r) {
  const Scene scene = block_drag(block, r.reducer, r.rings);
  SteadyDrag drag(scene);
  const std::size_t before = drag.records.size();
  std::vector<double> linearized, prepared, cpu;
  for (auto _ : state) {
    const std::size_t done = drag.records.size();
    std::clock_t start = 0;
    while (drag.records.size() == done) {
      drag.step();
      start = std::clock();
      drag.refresh_when_due();
    }
    cpu.push_back(1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
    // The parts that all reducers share are made once more; the rest of the refresh is the reducer's.
    const LocalModel& local = drag.local.model().model;
    linearized.push_back(
        milliseconds_of([&] { benchmark::DoNotOptimize(linearize(drag.session.model(), drag.refresher.state())); }));
    LocalModel copy = local;
    prepared.push_back(milliseconds_of([&] {
      benchmark::DoNotOptimize(prepare(std::move(copy), LocalScheme::implicit_euler, Metric::implicit, drag.local.h(),
                                       scene.collision.backend, drag.session.model().mesh().num_nodes(),
                                       static_cast<int>(drag.surface.triangles.size())));
    }));
    state.SetIterationTime(1e-3 * drag.records.back().refresh_ms);
  }
  std::vector<double> all, global;
  int definite = 0;
  for (const RefreshRecord& record : drag.records) {
    definite += record.definite_tangent;
    if (&record - drag.records.data() < static_cast<std::ptrdiff_t>(before)) continue;
    all.push_back(record.refresh_ms);
    if (record.global_ms) global.push_back(*record.global_ms);
  }
  const double whole = percentile(all, 0.5);
  state.counters["refresh_ms"] = whole;
  state.counters["cpu_ms"] = percentile(cpu, 0.5);  // of both threads: global step and refresh
  state.counters["linearize_ms"] = percentile(linearized, 0.5);
  state.counters["prepare_ms"] = percentile(prepared, 0.5);
  state.counters["reduce_ms"] = std::max(0.0, whole - percentile(linearized, 0.5) - percentile(prepared, 0.5));
  state.counters["global_ms"] = percentile(global, 0.5);
  state.counters["definite_tangents"] = definite;
  state.counters["nodes"] = drag.session.model().mesh().num_nodes();
  state.counters["dof"] = drag.local.model().model.dof();
}

const int kRegistered = [] {
  for (const BlockCells& block : kBlocks)
    for (const NamedReducer& r : tick_reducers())
      benchmark::RegisterBenchmark(
          text("Refresh/", r.name, "/", (block.across + 1) * (block.across + 1) * (block.up + 1)).c_str(), refreshes,
          block, r)
          ->Iterations(kRefreshes)
          ->UseManualTime()
          ->Unit(benchmark::kMillisecond);
  return 0;
}();

}  // namespace
}  // namespace kt
