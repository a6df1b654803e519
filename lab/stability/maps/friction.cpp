// Friction coefficient x tool speed x mesh size, for every contact method: where a drag loses its contact or sinks into
// the body, and where it buzzes or jumps by more than a person's JND.
#include <algorithm>
#include <cmath>

#include "core/base/numbers.hpp"
#include "core/base/parallel.hpp"
#include "lab/stability/bisect.hpp"
#include "lab/stability/runs/rays.hpp"
#include "lab/stability/runs/session_runs.hpp"

namespace kt {
namespace {

constexpr double kJnd = 0.1;

struct Method {
  const char* name;
  void (*choose)(Scene&);
};

const std::vector<Method> kMethods = {
    {"coulomb", [](Scene&) {}},
    {"coulomb, smooth surface", [](Scene& s) { s.contact.surface = "loop"; }},
    {"paper_stick_slip, identity",
     [](Scene& s) {
       s.contact.law = "paper_stick_slip";
       s.contact.metric = "identity";
       s.local.integrator = "implicit_euler";
     }},
    {"penalty, 200 N/m", [](Scene& s) { s.local.method = "penalty"; }},
    {"penalty, 2000 N/m",
     [](Scene& s) {
       s.local.method = "penalty";
       s.contact.penalty.stiffness = 2000;
     }},
    {"frozen", [](Scene& s) { s.local.method = "frozen"; }},
};

struct Row {
  Method method;
  double edge;  ///< of the mesh [m]
  std::string name() const { return text(method.name, " | edges of ", 1e3 * edge, " mm"); }
};

Scene drag(const Row& row, double mu, double speed) {
  Scene scene = slab_scene();
  constexpr double kLongest = 0.018, kSlowest = 0.19;  // [m], [s]: it stays on the slab
  scene.duration = 0.06 + 1e-3 * std::ceil(1e3 * std::min(kLongest / speed, kSlowest));
  scene.contact.mu_static = scene.contact.mu_kinetic = mu;
  scene.tool.path.press_drag->speed = speed;
  row.method.choose(scene);
  return scene;
}

MapPoint judge(const Row& row, double mu, double speed, const Mesh& mesh, const MapOptions& options) {
  const Scene scene = drag(row, mu, speed);
  const SessionRun run = run_session("friction", scene, mesh, options);
  MapPoint p = point_of(row.name(), speed, mu, run);
  if (run.result.stopped) return p;
  const ForceMetrics& f = run.force;
  p.value = std::max(f.buzz, f.crossing_jump);
  p.why = failure_of(run);
  if (p.why.empty() && f.lost_contacts > 0) p.why = text("contact lost ", f.lost_contacts, " times");
  if (p.why.empty() && run.result.tools[0].missed_impacts > 0)
    p.why = text("inside without contact in ", run.result.tools[0].missed_impacts, " ticks");
  // A virtual coupling lets the tool in by what its spring yields; beyond half of the press nothing is left of it.
  const double depth = scene.tool.path.press_drag->depth;
  if (p.why.empty() && run.deepest > 0.5 * depth)
    p.why = text("the tool is ", in_unit(run.deepest, "m"), " inside of the body");
  if (!p.why.empty()) {
    p.verdict = MapVerdict::fails;
    return p;
  }
  p.why = told("buzz ", in_percent(f.buzz), ", jump at edges ", in_percent(f.crossing_jump), ", ", 1e6 * run.deepest,
               " um inside");
  p.verdict = p.value > kJnd ? MapVerdict::degrades : MapVerdict::works;
  return p;
}

RayResult trace(const Row& row, double mu, const MapOptions& options) {
  RayResult out;
  const Mesh mesh = slab_mesh(row.edge);
  for (double v : {0.02, 0.1, 0.5}) out.points.push_back(judge(row, mu, v, mesh, options));
  // Between neighbours that differ, one step of bisection: verdicts along a ray need not change once only.
  for (std::size_t i = 0; i + 1 < out.points.size(); i += 1) {
    const MapPoint a = out.points[i], b = out.points[i + 1];
    if (a.verdict == b.verdict || b.x / a.x < 1.6) continue;
    out.points.insert(out.points.begin() + static_cast<std::ptrdiff_t>(i) + 1,
                      judge(row, mu, std::sqrt(a.x * b.x), mesh, options));
    ++i;
  }
  return out;
}

}  // namespace

StabilityMap map_friction(const MapOptions& options) {
  StabilityMap map;
  map.x_name = "tool speed [m/s]";
  map.y_name = "friction coefficient";
  map.x_log = map.y_log = true;
  const std::vector<double> edges =
      options.full ? std::vector<double>{0.0075, 0.005, 0.0025} : std::vector<double>{0.0075, 0.005};
  const std::vector<double> mus =
      options.full ? std::vector<double>{0.03, 0.1, 0.3, 0.6, 1, 2, 5} : std::vector<double>{0.1, 0.5, 1.5};
  std::vector<std::pair<Row, double>> rays;
  for (const Method& method : kMethods)
    for (double edge : edges)
      for (double mu : mus) rays.push_back({{method, edge}, mu});
  with_threads(1, [&] {
    run_rays(
        options, static_cast<int>(rays.size()), [&](int i) { return trace(rays[i].first, rays[i].second, options); },
        map);
  });
  int ours = 0, ours_fail = 0, others = 0, others_fail = 0;
  for (const MapPoint& p : map.points) {
    const bool is_ours = p.series.starts_with("coulomb"), has_failed = p.verdict == MapVerdict::fails;
    (is_ours ? ours : others) += 1;
    (is_ours ? ours_fail : others_fail) += has_failed;
  }
  map.claim = text("ours fails in ", ours_fail, " of ", ours, " drags, the baselines in ", others_fail, " of ", others);
  return map;
}

}  // namespace kt
