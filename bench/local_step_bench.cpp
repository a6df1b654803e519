// Cost of one haptic tick in steady sliding contact, whole and by stages; scenes/slab_drag.json, 2560 or 10240 surface
// triangles, wall reducer.
//   ./build/release/bench/local_step_bench --benchmark_counters_tabular=true
//   ./build/release/bench/local_step_bench --benchmark_filter='Tick/coarse' --benchmark_format=json
// TickBlock rows: the same over a block of 3703 nodes, each reducer.
// Tick rows: CPU time of the tick's thread; p50_us, p999_us and max_us over a drag with its refreshes.
#include <benchmark/benchmark.h>

#include "bench/steady_drag.hpp"
#include "collision/held/first_contact.hpp"
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

/// The local model of a drag at rest in time, to repeat one stage of the tick on it.
struct Still {
  explicit Still(const Setup& setup) : drag(slab_drag(setup.mesh, setup.shape, setup.rings)) {
    x = model().x0.head(prepared().patch_basis.rows()) + prepared().patch_basis * prepared().state.q;
    x_end = x;
    candidates.resize(model().patch.triangles.size());
    find_contacts();
  }
  const PreparedLocalModel& prepared() const { return drag.local.model(); }
  const LocalModel& model() const { return prepared().model; }

  int find_candidates() { return prepared().index->candidates(drag.sweep(), 1.05 * drag.tool.radius, candidates); }

  void find_contacts() {
    const Vec3 tool = drag.sweep().x_t0;
    const Contact& held = prepared().state.anchors.contacts[0];
    if (drag.tool.kind == ToolShape::Kind::point) {
      contacts.count = 0;
      contacts.add(track_point_contact(model().patch, x, tool, held.triangle));
      return;
    }
    const auto found = static_cast<std::size_t>(find_candidates());
    find_sphere_contacts(model().patch, x, tool, drag.tool.radius, 0.05 * drag.tool.radius, {candidates.data(), found},
                         held.triangle, contacts);
  }

  /// The contacts as the tick poses them, pressed together with 0.1 m/s.
  ContactProblem problem() const {
    const MatrixX& C = prepared().dynamics->metric().C;
    ContactProblem p;
    p.count = contacts.count;
    p.h = drag.local.h();
    p.velocity.setZero(3 * p.count);
    p.W.setZero(3 * p.count, 3 * p.count);
    for (int i = 0; i < p.count; ++i) {
      const Contact& a = contacts.contacts[i];
      p.normal[i] = a.normal;
      p.velocity.segment<3>(3 * i) = 0.1 * a.normal + Vec3(0.05, 0, 0);
      for (int k = 0; k < p.count; ++k) {
        const Contact& b = contacts.contacts[k];
        for (int r = 0; r < 3; ++r)
          for (int s = 0; s < 3; ++s)
            p.W.block<3, 3>(3 * i, 3 * k) +=
                a.bary[r] * b.bary[s] *
                C.block<3, 3>(3 * model().patch.triangles[a.triangle][r], 3 * model().patch.triangles[b.triangle][s]);
      }
    }
    return p;
  }

  SteadyDrag drag;
  VectorX x, x_end;
  ContactSet contacts;
  std::vector<int> candidates;
};

void free_motion(benchmark::State& state, const Setup& setup) {
  const Still still(setup);
  const PreparedLocalModel& m = still.prepared();
  VectorX v = m.state.q, v_end = v, x = still.x, u = still.x;
  for (auto _ : state) {
    m.recover_patch(m.state.q, x);
    x += m.model.x0.head(x.size());
    m.dynamics->free_motion(m.state.q, m.state.q_rate, v, v_end);
    m.recover_patch(v, u);
    benchmark::DoNotOptimize(u.data());
  }
}

void broad_phase(benchmark::State& state, const Setup& setup) {
  Still still(setup);
  int found = 0;
  for (auto _ : state) {
    still.prepared().index->refit(still.x, still.x_end);
    found = still.find_candidates();
    benchmark::DoNotOptimize(found);
  }
  state.counters["candidates"] = found;
}

void narrow_phase(benchmark::State& state, const Setup& setup) {
  Still still(setup);
  still.prepared().index->refit(still.x, still.x_end);
  const MovingTriangles surface{still.model().patch.triangles, still.x, still.x_end};
  for (auto _ : state)
    benchmark::DoNotOptimize(find_first_contact(*still.prepared().index, surface, still.drag.tool, still.drag.sweep(),
                                                {}, still.candidates));
}

void contact_finding(benchmark::State& state, const Setup& setup) {
  Still still(setup);
  still.prepared().index->refit(still.x, still.x_end);
  for (auto _ : state) {
    still.find_contacts();
    benchmark::DoNotOptimize(still.contacts);
  }
  state.counters["contacts"] = still.contacts.count;
}

void contact_solve(benchmark::State& state, const Setup& setup) {
  const Still still(setup);
  const ContactProblem problem = still.problem();
  const auto solver = make_contact_solver("coulomb", {0.5, 0.5});
  ContactSolution solution;
  for (auto _ : state) {
    solution.impulse.setZero(3 * problem.count);  // a cold start: the tick's warm one is cheaper
    solver->solve(problem, solution);
    benchmark::DoNotOptimize(solution);
  }
  state.counters["sweeps"] = solution.iterations;
}

/// Motion of the patch and of the reduced coordinates by the contact impulses.
void response(benchmark::State& state, const Setup& setup) {
  const Still still(setup);
  const PreparedLocalModel& m = still.prepared();
  const MatrixX &C = m.dynamics->metric().C, &Y = m.dynamics->metric().Y;
  VectorX du = VectorX::Zero(C.rows()), q = m.state.q;
  for (auto _ : state) {
    for (const Contact& contact : still.contacts)
      for (int c = 0; c < 3; ++c) {
        const Eigen::Index at = 3 * still.model().patch.triangles[contact.triangle][c];
        const Vec3 impulse = 1e-9 * contact.bary[c] * contact.normal;
        du.noalias() += C.middleCols<3>(at) * impulse;
        q.noalias() += Y.middleCols<3>(at) * impulse;
      }
    benchmark::DoNotOptimize(q.data());
    benchmark::DoNotOptimize(du.data());
  }
}

const int kRegistered = [] {
  for (const NamedReducer& r : tick_reducers())
    benchmark::RegisterBenchmark((std::string("TickBlock/") + r.name).c_str(), tick_block, r)
        ->Iterations(kBlockTicks)
        ->UseManualTime()
        ->Unit(benchmark::kMicrosecond);
  for (const Setup& s : kSetups) {
    benchmark::RegisterBenchmark((std::string("Tick/") + s.name).c_str(), tick, s)
        ->Iterations(kTicks)
        ->UseManualTime()
        ->Unit(benchmark::kMicrosecond);
    const std::pair<const char*, void (*)(benchmark::State&, const Setup&)> stages[] = {
        {"FreeMotion/", free_motion},         {"BroadPhase/", broad_phase},     {"NarrowPhase/", narrow_phase},
        {"ContactFinding/", contact_finding}, {"ContactSolve/", contact_solve}, {"Response/", response}};
    if (std::string(s.name).rfind("coarse", 0) == 0)
      for (const auto& [name, run] : stages)
        benchmark::RegisterBenchmark((std::string(name) + s.name).c_str(), run, s)->Unit(benchmark::kMicrosecond);
  }
  return 0;
}();

}  // namespace
}  // namespace kt
