// Cost of the broad phases of collision/broad/triangle_index.def on bumpy tori of 200 to 1 000 000 triangles.
//   ./build/release/bench/broad_phase_bench
//   scripts/broad_phase      runs it, writes bench/results/broad_phase.csv and the table in docs/collision.md
// Rows are ACTION/BACKEND/TRIANGLES:
//   build         made new
//   refit         everything moves, by a tenth of an edge
//   moved_N       N neighbouring vertices move, always the same; moved_N_anywhere: each time others, far apart
//   point         candidates of a point's path of half a percent of the body; sphere: with a radius of 2 %; fast: a
//   point's
//                 path of 30 %
// Backends embree_triangles and embree_boxes are Embree's own refit, which the haptic tick avoids: rtcCommitScene over
// its triangles at one end of the step, or over our swept boxes.
// The label is a hash of candidates found in that state: the same in all rows of an action and a size.
#include <benchmark/benchmark.h>

#include <map>
#include <random>

#include "collision/broad/triangle_index.hpp"
#include "collision/shape/swept_box.hpp"
#include "core/body/state.hpp"
#if KT_WITH_EMBREE
#if KT_EMBREE_MAJOR == 3
#include <embree3/rtcore.h>
#else
#include <embree4/rtcore.h>
#endif
#endif

namespace kt {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kPlaces = 256;  // of moved_N_anywhere
constexpr int kSweeps = 200;
constexpr int kHashed = 20, kHashedTicks = 16;  // sweeps that the label covers, and ticks before them

/// Nodes (i, j) around the ring and around the tube, 2 nu nv triangles; about 0.1 m.
struct Torus {
  int nu, nv;
  int node_at(int i, int j) const { return ((i % nu + nu) % nu) * nv + (j % nv + nv) % nv; }

  std::vector<Triangle> triangles() const {
    std::vector<Triangle> out;
    for (int i = 0; i < nu; ++i)
      for (int j = 0; j < nv; ++j) {
        out.push_back({node_at(i, j), node_at(i + 1, j), node_at(i + 1, j + 1)});
        out.push_back({node_at(i, j), node_at(i + 1, j + 1), node_at(i, j + 1)});
      }
    return out;
  }

  /// Bumps of a tenth of the tube; with `phase` [rad] they wander.
  VectorX positions(double phase) const {
    VectorX x(3 * nu * nv);
    for (int i = 0; i < nu; ++i)
      for (int j = 0; j < nv; ++j) {
        const double a = 2 * kPi * i / nu, b = 2 * kPi * j / nv;
        const double tube = 0.015 * (1 + 0.1 * std::sin(7 * a + phase) * std::cos(5 * b + phase));
        node(x, node_at(i, j)) = Vec3((0.035 + tube * std::cos(b)) * std::cos(a),
                                      (0.035 + tube * std::cos(b)) * std::sin(a), tube * std::sin(b));
      }
    return x;
  }

  double edge() const { return 2 * kPi * 0.035 / nu; }

  /// The first `count` nodes around node (i, j), ring by ring.
  std::vector<int> neighbourhood(int i, int j, int count) const {
    std::vector<int> out{node_at(i, j)};
    for (int ring = 1; static_cast<int>(out.size()) < count; ++ring)
      for (int di = -ring; di <= ring; ++di)
        for (int dj = -ring; dj <= ring; ++dj)  // the diagonal (1, 1) is an edge, (1, -1) is not
          if (std::max({std::abs(di), std::abs(dj), std::abs(di - dj)}) == ring && static_cast<int>(out.size()) < count)
            out.push_back(node_at(i + di, j + dj));
    return out;
  }
};

constexpr Torus kTori[] = {{14, 7}, {32, 16}, {100, 50}, {316, 158}, {1000, 500}};

/// A body with everything the rows need, and one index over it.
struct Subject {
  Subject(const Torus& of, const std::string& backend)
      : torus(of), triangles(of.triangles()), index(make_triangle_index(backend)) {
    const double phase = 0.1 * torus.edge() / 0.0015;
    for (std::size_t k = 0; k < x.size(); ++k) x[k] = torus.positions(phase * static_cast<double>(k));
    index->build(triangles, x[0]);
    found.resize(triangles.size());
    std::mt19937_64 random(1);
    for (ToolSweep& s : slow) s = sweep(random, 0.0005);
    for (ToolSweep& s : fast) s = sweep(random, 0.03);
  }

  ToolSweep sweep(std::mt19937_64& random, double length) const {
    const auto uniform = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
    const Vec3 start = node(x[1], static_cast<int>(random() % static_cast<std::size_t>(x[1].size() / 3)));
    const Vec3 way = Vec3(uniform(), uniform(), uniform()).normalized();
    return {start - 0.5 * length * way, start + 0.5 * length * way};
  }

  std::string hash(std::span<const ToolSweep> sweeps, double margin) {
    StateHash out;
    for (const ToolSweep& sweep : sweeps.first(std::min<std::size_t>(sweeps.size(), kHashed))) {
      const int count = index->candidates(sweep, margin, found);
      for (int i = 0; i < count; ++i) out.add(found[i]);
      out.add(count);
    }
    char buffer[20];
    std::snprintf(buffer, sizeof buffer, "%016llx", static_cast<unsigned long long>(out.value()));
    return buffer;
  }

  Torus torus;
  std::vector<Triangle> triangles;
  std::array<VectorX, 3> x;
  std::unique_ptr<TriangleIndex> index;
  std::array<ToolSweep, kSweeps> slow, fast;
  std::vector<int> found;
};

/// The subject of the rows that run now: only one at a time, for the largest fill the memory.
Subject& subject(const Torus& torus, const std::string& backend) {
  static std::unique_ptr<Subject> current;
  static std::string name;
  const std::string wanted = backend + std::to_string(torus.nu);
  if (!current || name != wanted) {
    current.reset();
    current = std::make_unique<Subject>(torus, backend);
    name = wanted;
  }
  return *current;
}

void build(benchmark::State& state, const Torus& torus, const std::string& backend) {
  Subject& s = subject(torus, backend);
  for (auto _ : state) s.index->build(s.triangles, s.x[0]);
  state.SetLabel(s.hash(s.slow, 0.002));
}

void refit(benchmark::State& state, const Torus& torus, const std::string& backend) {
  Subject& s = subject(torus, backend);
  s.index->refit(s.x[0], s.x[1]);
  state.SetLabel(s.hash(s.slow, 0.002));
  for (std::size_t k = 0; auto _ : state) {
    k = 1 - k;
    s.index->refit(s.x[k], s.x[k + 1]);
  }
}

void moved(benchmark::State& state, const Torus& torus, const std::string& backend, int count, int places) {
  Subject& s = subject(torus, backend);
  count = std::min(count, static_cast<int>(s.x[0].size() / 3));
  std::vector<std::vector<int>> vertices;
  for (int p = 0; p < places; ++p)  // far apart, and from one to the next too
    vertices.push_back(torus.neighbourhood(p * 89 % torus.nu, p * 113 % torus.nv, count));
  VectorX x_t0 = s.x[0], x_t1 = s.x[1];
  const auto move = [&](std::size_t tick) {
    const std::vector<int>& here = vertices[tick % vertices.size()];
    const double way = (tick / vertices.size() % 2 ? -0.1 : 0.1) * s.torus.edge();
    for (const int v : here) {
      node(x_t0, v) = Vec3(node(x_t1, v));
      node(x_t1, v).array() += way;
    }
    s.index->refit_moved(here, x_t0, x_t1);
  };
  s.index->refit(x_t0, x_t1);
  std::size_t tick = 0;
  while (tick < kHashedTicks) move(tick++);
  std::vector<ToolSweep> here;
  for (const auto& place : vertices) here.push_back({node(x_t0, place[0]), node(x_t1, place.back())});
  state.SetLabel(s.hash(here, 0));
  for (auto _ : state) move(tick++);
}

void query(benchmark::State& state, const Torus& torus, const std::string& backend, bool is_fast, double margin) {
  Subject& s = subject(torus, backend);
  s.index->refit(s.x[0], s.x[1]);
  const auto& sweeps = is_fast ? s.fast : s.slow;
  state.SetLabel(s.hash(sweeps, margin));
  double count = 0;
  for (std::size_t k = 0; auto _ : state) {
    count += s.index->candidates(sweeps[k], margin, s.found);
    k = (k + 1) % kSweeps;
  }
  state.counters["candidates"] = count / static_cast<double>(state.iterations());
}

#if KT_WITH_EMBREE
/// Embree's refit as its manual has it: refitted geometry in a scene of low quality, robust, one thread.
struct EmbreeScene {
  EmbreeScene(const Torus& torus, RTCGeometryType type) : triangles(torus.triangles()) {
    for (std::size_t k = 0; k < x.size(); ++k) x[k] = torus.positions(0.1 * torus.edge() / 0.0015 * double(k));
    boxes.resize(triangles.size());
    scene = rtcNewScene(device);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_LOW);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC);
    geometry = rtcNewGeometry(device, type);
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_REFIT);
    if (type == RTC_GEOMETRY_TYPE_USER) {
      rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(triangles.size()));
      rtcSetGeometryUserData(geometry, this);
      rtcSetGeometryBoundsFunction(geometry, bounds_of, nullptr);
    } else {
      vertices.resize(static_cast<std::size_t>(x[0].size()) + 4);
      rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices.data(), 0, 12,
                                 static_cast<std::size_t>(x[0].size() / 3));
      rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles.data(), 0, 12,
                                 triangles.size());
    }
    refit(0);
    rtcAttachGeometry(scene, geometry);
    rtcCommitScene(scene);
  }
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;
  ~EmbreeScene() {
    rtcReleaseGeometry(geometry);
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }

  void refit(std::size_t k) {
    if (vertices.empty()) {
      for (std::size_t t = 0; t < triangles.size(); ++t) boxes[t] = swept_box(triangles[t], x[k], x[k + 1]);
    } else {
      for (Eigen::Index i = 0; i < x[k].size(); ++i)
        vertices[static_cast<std::size_t>(i)] = static_cast<float>(x[k][i]);
      rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
    }
    rtcCommitGeometry(geometry);
    rtcCommitScene(scene);
  }

  static void bounds_of(const RTCBoundsFunctionArguments* args) {
    const Box& box = static_cast<EmbreeScene*>(args->geometryUserPtr)->boxes[args->primID];
    *args->bounds_o = {float(box.low[0]),  float(box.low[1]),  float(box.low[2]),  0,
                       float(box.high[0]), float(box.high[1]), float(box.high[2]), 0};
  }

  RTCDevice device = rtcNewDevice("threads=1,set_affinity=0");
  RTCScene scene;
  RTCGeometry geometry;
  std::vector<Triangle> triangles;
  std::array<VectorX, 3> x;
  std::vector<float> vertices;
  std::vector<Box> boxes;
};

void embree_refit(benchmark::State& state, const Torus& torus, RTCGeometryType type) {
  EmbreeScene scene(torus, type);
  scene.refit(1);
  for (std::size_t k = 0; auto _ : state) {
    scene.refit(k);
    k = 1 - k;
  }
}
#endif

template <class Run, class... Args>
void add_row(const std::string& action, const std::string& backend, const Torus& torus, Run run, Args... args) {
  benchmark::RegisterBenchmark((action + "/" + backend + "/" + std::to_string(2 * torus.nu * torus.nv)).c_str(), run,
                               torus, args...)
      ->Unit(benchmark::kMicrosecond);
}

const int kRegistered = [] {
  for (const Torus& torus : kTori) {
#if KT_WITH_EMBREE
    add_row("refit", "embree_triangles", torus, embree_refit, RTC_GEOMETRY_TYPE_TRIANGLE);
    add_row("refit", "embree_boxes", torus, embree_refit, RTC_GEOMETRY_TYPE_USER);
#endif
    for (const BackendInfo& b : triangle_index_backends()) {
      if (!b.available) continue;
      add_row("build", b.name, torus, build, b.name);
      add_row("refit", b.name, torus, refit, b.name);
      add_row("point", b.name, torus, query, b.name, false, 0.0);
      add_row("sphere", b.name, torus, query, b.name, false, 0.002);
      add_row("fast", b.name, torus, query, b.name, true, 0.0);
      for (const int count : {7, 19, 100}) {
        const std::string action = "moved_" + std::to_string(count);
        add_row(action, b.name, torus, moved, b.name, count, 1);
        add_row(action + "_anywhere", b.name, torus, moved, b.name, count, kPlaces);
      }
    }
  }
  return 0;
}();

}  // namespace
}  // namespace kt
