// One implicit step of the clamped cantilever, 0.1 x 0.1 x 0.4 m, E = 1e5 Pa, nu = 0.3, falling under its weight in
// steps of 10 ms: by size and solver, with its parts.
//   ./build/release/bench/fem_step_bench --benchmark_counters_tabular=true
// Step rows: ms a step over 16 steps; tip: where the middle of the free end is then [m]; off: from the direct solver's.
#include <benchmark/benchmark.h>

#include <chrono>

#include "bench/cantilever.hpp"
#include "core/base/parallel.hpp"
#include "core/global/integrator.hpp"
#include "core/linear/sparse_solver.hpp"
#include "core/linear/step_matrix.hpp"

namespace kt {
namespace {

constexpr double kDt = 0.01;
constexpr int kSteps = 16;

struct Setup {
  const char* name;
  int cells;
  const char *material, *solver;
};
constexpr Setup kSetups[] = {
    {"200/direct", 3, "corotational", "direct"}, {"200/pcg", 3, "corotational", "pcg"},
    {"400/direct", 4, "corotational", "direct"}, {"400/pcg", 4, "corotational", "pcg"},
    {"800/direct", 5, "corotational", "direct"}, {"800/pcg", 5, "corotational", "pcg"},
    {"1k/direct", 6, "corotational", "direct"},  {"1k/pcg", 6, "corotational", "pcg"},
    {"8k/direct", 12, "corotational", "direct"}, {"8k/pcg", 12, "corotational", "pcg"},
    {"8k/pcg/neo", 12, "neo_hookean", "pcg"},    {"47k/pcg", 22, "corotational", "pcg"},
};

double tip_after(const DeformableModel& model, const Setup& setup, double* seconds, StepStatistics* statistics) {
  const auto stepper = make_integrator("implicit_euler", {.solver = setup.solver, .tolerance = 1e-5});
  State s = rest_state(model);
  const VectorX none = VectorX::Zero(s.x.size());
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < kSteps; ++i) stepper->step(model, none, kDt, s);
  *seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  *statistics = stepper->statistics();
  return tip_deflection(model, s);
}

void step(benchmark::State& state, const Setup& setup) {
  const auto model = cantilever(setup.cells, {.young = 1e5, .poisson = 0.3, .material = setup.material});
  double seconds = 0, tip = 0;
  StepStatistics statistics;
  for (auto _ : state) {
    tip = tip_after(*model, setup, &seconds, &statistics);
    state.SetIterationTime(seconds / kSteps);
  }
  state.counters["nodes"] = model->mesh().num_nodes();
  state.counters["tip"] = tip;
  state.counters["linear_iterations"] = static_cast<double>(statistics.linear_iterations) / kSteps;
}

void assembly(benchmark::State& state, const char* material, TangentKind kind, int threads) {
  const auto model = cantilever(12, {.young = 1e5, .poisson = 0.3, .material = material});
  State s = rest_state(*model);
  for (int i = 0; i < s.x.size(); i += 3) s.x[i] += 0.1 * s.x[i + 2] * s.x[i + 2];  // bent
  Tangent tangent;
  with_threads(threads, [&] {
    for (auto _ : state) model->update_tangent(s, kind, tangent);
  });
  state.counters["ns_a_tet"] =
      benchmark::Counter(static_cast<double>(model->mesh().tetrahedra.size()),
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void forces(benchmark::State& state, const char* material) {
  const auto model = cantilever(12, {.young = 1e5, .poisson = 0.3, .material = material});
  State s = rest_state(*model);
  VectorX f;
  for (auto _ : state) model->force(s, f);
  state.counters["ns_a_tet"] =
      benchmark::Counter(static_cast<double>(model->mesh().tetrahedra.size()),
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

/// What a step by `direct` cannot go below: a factorization and a solution of its matrix, analyzed before.
void factor_and_solve(benchmark::State& state, int cells) {
  const auto model = cantilever(cells, {.young = 1e5, .poisson = 0.3, .material = "corotational"});
  StepMatrix matrix(make_free_dofs(model->mesh().num_nodes(), model->fixed_nodes()));
  const Tangent tangent = model->tangent(rest_state(*model), TangentKind::definite);
  const SparseMatrix& sum = matrix.sum({{{1, &model->mass()}, {-kDt, &tangent.dfdv}, {-kDt * kDt, &tangent.dfdx}}});
  const auto solver = make_sparse_solver();
  const VectorX rhs = VectorX::Ones(sum.rows());
  solver->factor(sum);
  for (auto _ : state) {
    solver->factor(sum);
    benchmark::DoNotOptimize(solver->solve(rhs));
  }
}

const bool kRegistered = [] {
  for (const Setup& s : kSetups)
    benchmark::RegisterBenchmark((std::string("Step/") + s.name).c_str(), step, s)
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark("FactorAndSolve/1k", factor_and_solve, 6)->Unit(benchmark::kMillisecond);
  benchmark::RegisterBenchmark("FactorAndSolve/8k", factor_and_solve, 12)->Unit(benchmark::kMillisecond);
  for (const char* material : {"linear", "corotational", "stvk", "neo_hookean"}) {
    benchmark::RegisterBenchmark((std::string("Tangent/") + material).c_str(), assembly, material, TangentKind::exact,
                                 2);
    benchmark::RegisterBenchmark((std::string("TangentOneThread/") + material).c_str(), assembly, material,
                                 TangentKind::exact, 1);
    benchmark::RegisterBenchmark((std::string("DefiniteTangent/") + material).c_str(), assembly, material,
                                 TangentKind::definite, 2);
    benchmark::RegisterBenchmark((std::string("DefiniteTangentOneThread/") + material).c_str(), assembly, material,
                                 TangentKind::definite, 1);
    benchmark::RegisterBenchmark((std::string("Force/") + material).c_str(), forces, material);
  }
  return true;
}();

}  // namespace
}  // namespace kt
