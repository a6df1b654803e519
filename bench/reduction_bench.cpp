// A refresh of large bodies on one core, part by part: clamped blocks of neo-Hookean elements, a patch of 19 vertices,
// krylov {0, 200} Hz.
//   ./build/release/bench/reduction_bench --benchmark_counters_tabular=true
#include <benchmark/benchmark.h>
#include <malloc.h>

#include <map>

#include "bench/two_rings.hpp"
#include "core/base/cpu_time.hpp"
#include "core/base/error.hpp"
#include "core/base/parallel.hpp"
#include "core/body/tangent_model.hpp"
#include "core/local/certificate.hpp"
#include "models/model.hpp"

namespace kt {
namespace {

/// A block of cells x cells x height cubes over 0.1 x 0.1 m, clamped at its base, pressed a little; the patch is two
/// rings around the middle of its top.
struct Block {
  Block(int cells, int height) {
    Mesh mesh = kuhn_block(cells, cells, height, 0.1 / cells);
    std::vector<int> base;
    for (int i = 0; i < (cells + 1) * (cells + 1); ++i) base.push_back(i);
    model = make_model("fem", mesh, {.young = 1e4, .poisson = 0.4, .damping_stiffness = 2e-3, .fixed_nodes = base});
    State state = rest_state(*model);
    for (int i = 0; i < mesh.num_nodes(); ++i) state.x[3 * i + 2] *= 0.97;
    surface = make_surface(mesh);
    const int middle = (height * (cells + 1) + cells / 2) * (cells + 1) + cells / 2;
    site = {node(state.x, middle), surface.topology.triangles_of(middle)[0], 1e-9};
    patch = two_rings(surface, middle);
    linearize(*model, state, TangentKind::symmetric, tangent);
  }
  std::unique_ptr<DeformableModel> model;
  Surface surface;
  ContactSite site;
  SurfacePatch patch;
  TangentModel tangent;
};

const Block& block_of(const benchmark::State& state) {
  static std::map<std::int64_t, Block> made;
  return made.try_emplace(state.range(0), static_cast<int>(state.range(0)), static_cast<int>(state.range(1)))
      .first->second;
}

/// What a refresh is made of; each is timed with the ones before it done.
enum Part {
  linearizing,
  grading_anew,
  grading,
  answering,
  orthonormalizing,
  confining,
  krylov,
  sampling,
  whole_krylov
};
constexpr const char* kParts[] = {"linearize",     "grade anew",       "grade",
                                  "factor, solve", "orthonormalize",   "confine",
                                  "krylov in all", "certify a sample", "krylov, whole body"};

/// One core does the slow side; the time is the thread's own.
void BM_Refresh(benchmark::State& state) {
  const Block& b = block_of(state);
  const Part part = static_cast<Part>(state.range(2));
  GradedBody graded;
  const ReduceOptions options{.graded = &graded};
  const ReduceFn reduce = find_reducer("krylov");
  const LocalModel model = reduce(b.tangent, b.patch, b.site, options);
  const FreeBody& body = graded.update(b.tangent, b.patch);
  const auto answer = [&] {
    return responses(body, b.patch, options.shifts_hz, graded.solver(), options.echoes, options.slopes);
  };
  const MatrixX answers = answer();
  const auto orthonormalize = [&] {
    return orthonormal_motions(body.mass, answers, options.rank_tolerance, 3 * options.echoes);
  };
  const RowMatrix V = orthonormalize();
  const int vertex = certified_vertices(model, b.site).front();
  TangentModel tangent = b.tangent;
  const auto work = [&] {
    switch (part) {
      case linearizing:
        linearize(*b.model, b.tangent.state, TangentKind::symmetric, tangent);
        break;
      case grading_anew:
        benchmark::DoNotOptimize(GradedBody().update(b.tangent, b.patch).force.data());
        break;
      case grading:
        graded.update(b.tangent, b.patch);
        break;
      case answering:
        benchmark::DoNotOptimize(answer());
        break;
      case orthonormalizing:
        benchmark::DoNotOptimize(orthonormalize());
        break;
      case confining:
        benchmark::DoNotOptimize(confine(b.tangent, body, b.patch, V));
        break;
      case krylov:
        benchmark::DoNotOptimize(reduce(b.tangent, b.patch, b.site, options));
        break;
      case sampling:
        benchmark::DoNotOptimize(estimate_error(graded, model, vertex, 50));
        break;
      case whole_krylov:
        benchmark::DoNotOptimize(reduce(b.tangent, b.patch, b.site, {.grading = 0}));
        break;
    }
  };
  with_threads(1, [&] {
    for (auto _ : state) {
      const double start = 1e-3 * thread_time_ms();
      work();
      state.SetIterationTime(1e-3 * thread_time_ms() - start);
    }
  });
  state.SetLabel(kParts[part]);
  state.counters["nodes"] = b.model->mesh().num_nodes();
  state.counters["kept"] = graded.num_kept();
  state.counters["dof"] = model.dof();
}

/// Freed memory is used again: else every large matrix is fetched from the system, page by page, and given back.
[[maybe_unused]] const bool keeps_memory = [] {
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  return true;
}();

BENCHMARK(BM_Refresh)
    ->ArgNames({"cells", "height", "part"})
    ->Apply([](benchmark::internal::Benchmark* bench) {
      for (auto [cells, height] : {std::pair{14, 4}, {20, 7}, {32, 9}})  // 1,125, 3,528 and 10,890 nodes
        for (int part = linearizing; part <= whole_krylov; ++part) bench->Args({cells, height, part});
    })
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
}  // namespace
}  // namespace kt
