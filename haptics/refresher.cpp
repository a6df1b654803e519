#include "haptics/refresher.hpp"

#include <algorithm>
#include <chrono>
#include <optional>

#include "collision/closest_point.hpp"
#include "core/error.hpp"
#include "core/sparse_solver.hpp"

namespace kt {
namespace {

double milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

bool is_positive_definite(const SparseMatrix& matrix) {
  return matrix.rows() == 0 || make_sparse_solver()->factor(matrix);
}

}  // namespace

LocalScheme local_scheme(const std::string& integrator) {
  if (integrator == "symplectic_euler") return LocalScheme::symplectic_euler;
  if (integrator == "implicit_euler") return LocalScheme::implicit_euler;
  throw_unknown("local.integrator", integrator, {"symplectic_euler", "implicit_euler"});
}

Metric contact_metric(const std::string& name) {
  if (name == "identity") return Metric::identity;
  if (name == "mass") return Metric::mass;
  if (name == "implicit") return Metric::implicit;
  throw_unknown("contact.metric", name, {"identity", "mass", "implicit"});
}

Refresher::Refresher(const DeformableModel& model, const Surface& surface, const Scene& scene, const ToolShape& tool,
                     double max_speed, const State& start)
    : surface_(surface),
      scene_(scene),
      tool_(tool),
      max_speed_(max_speed),
      global_(model,
              make_integrator(scene.global.integrator, {.solver = scene.global.solver,
                                                        .tolerance = scene.global.tolerance,
                                                        .definite = scene.global.definite}),
              1 / scene.global.rate_hz, start),
      reduce_(find_reducer(scene.local.reducer)),
      scheme_(local_scheme(scene.local.integrator)),
      metric_(contact_metric(scene.contact.metric)) {}

/// How far the tool's surface gets while the model made at time t is in use [m].
double Refresher::reach(double t) const {
  const double latency = 1e-3 * scene_.link.latency_ms;
  double in_use = 1 / scene_.global.rate_hz + latency;
  // In two threads a model arrives after one interval and serves for the next; a slow body makes both longer.
  if (scene_.link.type == "thread") in_use = 2 * std::max(1 / scene_.global.rate_hz, t - last_) + latency;
  return 1.5 * tool_.radius + max_speed_ * in_use;
}

ContactSite Refresher::find_site(const Vec3& tool, int triangle, double reach) const {
  const VectorX& x = global_.state().x;
  ContactSite site{tool, triangle, reach};
  double nearest = std::numeric_limits<double>::infinity();
  const auto consider = [&](int t) {
    const Triangle& v = surface_.triangles[t];
    const ClosestPoint at = closest_point_on_triangle(tool, node(x, v[0]), node(x, v[1]), node(x, v[2]));
    if (at.distance_sq < nearest) {
      nearest = at.distance_sq;
      site.centre = at.point;
      site.triangle = t;
    }
  };
  if (triangle >= 0)  // in contact: there, not on the other side of a thin body
    consider(triangle);
  else
    for (int t = 0; t < static_cast<int>(surface_.triangles.size()); ++t) consider(t);
  return site;
}

/// Springs resist stretching only: a tetrahedron pushed through itself does not come back.
void Refresher::count_inverted() {
  const State& s = global_.state();
  int count = 0;
  for (const Tetrahedron& t : global_.model().mesh().tetrahedra) count += tetrahedron_volume(s.x, t) < 0;
  if (count > 0 && inverted_from < 0) inverted_from = s.t;
  inverted_tetrahedra = std::max(inverted_tetrahedra, count);
}

std::unique_ptr<PreparedLocalModel> Refresher::refresh(double t, const Vec3& tool,
                                                       std::span<const LocalReport> reports) {
  auto start = std::chrono::steady_clock::now();
  std::vector<ContactSample> history;
  for (const LocalReport& report : reports)
    history.insert(history.end(), report.samples.begin(), report.samples.begin() + report.count);
  std::vector<ContactHold> holds;
  if (!reports.empty())
    for (const ContactSample& s :
         std::span(reports.back().samples).first(static_cast<std::size_t>(reports.back().count)))
      holds.push_back({s.nodes, s.bary, s.normal, s.point, s.sticks});
  if (t > global_.state().t) {
    global_.advance(t, history, holds);
    global_ms.push_back(milliseconds_since(start));
    count_inverted();
  }

  start = std::chrono::steady_clock::now();
  const ContactSite site = find_site(tool, reports.empty() ? -1 : reports.back().triangle, reach(t));
  last_ = t;
  const SurfacePatch patch = make_patch(surface_, global_.state().x, site);
  const ReduceOptions options{.rings = scene_.local.rings, .graded = &graded_};
  const auto reduce = [&](TangentKind kind) {
    linearize(global_.model(), global_.state(), kind, tangent_);
    return reduce_(tangent_, patch, site, options);
  };
  // A compressed body can have an indefinite tangent; a local model that gains energy would be worse than a stiffer
  // one.
  const auto if_definite = [&]() -> std::optional<LocalModel> {
    try {
      LocalModel exact = reduce(TangentKind::exact);
      if (is_positive_definite(exact.stiffness)) return exact;
    } catch (const IndefiniteTangent&) {
    }
    return std::nullopt;
  };
  std::optional<LocalModel> exact = if_definite();
  LocalModel local = exact ? std::move(*exact) : reduce(TangentKind::definite);
  if (!exact) {
    local.definite_tangent = true;
    ++definite_tangents;
  }
  local.frame = frame_++;
  auto out = prepare(std::move(local), scheme_, metric_, 1 / scene_.local.rate_hz, scene_.collision.backend,
                     global_.model().mesh().num_nodes(), static_cast<int>(surface_.triangles.size()));
  refresh_ms.push_back(milliseconds_since(start));
  return out;
}

}  // namespace kt
