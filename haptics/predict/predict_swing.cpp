#include "haptics/predict/predict_swing.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include "collision/shape/closest_point.hpp"
#include "core/base/numbers.hpp"
#include "core/body/near_triangles.hpp"
#include "core/contact_surface/contact_surface.hpp"
#include "core/global/newton.hpp"
#include "haptics/predict/predict.hpp"
#include "haptics/setup/built_scene.hpp"

namespace kt {
namespace {

constexpr int kIterations = 3;          // of inverse iteration: from the static answer, two digits of the frequency
constexpr double kMostly = 0.5;         // share of what gives way: the body swings as a whole
constexpr double kSwings = 0.3;         // damping ratio below which a few swings are felt
constexpr double kFelt = 0.05;          // of the depth: height of the swing, half of what people notice
constexpr std::size_t kPlaces = 40;     // of the path
constexpr std::size_t kWork = 1000000;  // closest points: below a tenth of a second

/// Where the tool gets deepest below the surface at rest: depth [m], triangle (-1: nowhere), time [s].
struct Deepest {
  double depth = 0, t = 0;
  int triangle = -1;
};

Vec3 area_of(const VectorX& x, const Triangle& t) {
  return 0.5 * (node(x, t[1]) - node(x, t[0])).cross(node(x, t[2]) - node(x, t[0]));
}

Deepest find_deepest(const BuiltScene& built) {
  const std::vector<TimedPoint>& path = built.path();
  const VectorX& x = built.start().x;
  Deepest out;
  if (built.surface().triangles.empty()) return out;
  const std::size_t places = std::clamp<std::size_t>(kWork / built.surface().triangles.size(), 4, kPlaces);
  for (std::size_t k = 0; k <= places; ++k) {
    const std::size_t i = k * (path.size() - 1) / places;
    if (path[i].t > built.scene().duration) break;
    double nearest = std::numeric_limits<double>::infinity(), depth = 0;
    int triangle = -1;
    for_each_near(built.surface(), x, path[i].x, nearest, [&](int m) {
      const Triangle& t = built.surface().triangles[static_cast<std::size_t>(m)];
      const ClosestPoint at = closest_point_on_triangle(path[i].x, node(x, t[0]), node(x, t[1]), node(x, t[2]));
      if (at.distance_sq >= nearest) return;
      nearest = at.distance_sq;
      triangle = m;
      const bool is_inside = area_of(x, t).dot(path[i].x - at.point) < 0;
      depth = built.tool().radius + (is_inside ? 1 : -1) * std::sqrt(at.distance_sq);
    });
    if (depth > out.depth) out = {depth, path[i].t, triangle};
  }
  return out;
}

/// Where the tool is along `normal` at time t [m]; before and after its path it rests.
double along(const std::vector<TimedPoint>& path, const Vec3& normal, double t) {
  const auto next = std::ranges::upper_bound(path, t, {}, &TimedPoint::t);
  if (next == path.begin()) return normal.dot(path.front().x);
  if (next == path.end()) return normal.dot(path.back().x);
  const auto last = next - 1;
  return normal.dot(last->x + (t - last->t) / (next->t - last->t) * (next->x - last->x));
}

/// Largest change of the tool's velocity along `normal`, of means over a quarter of a swing, up to that time [m/s]: a
/// body that is pushed evenly goes along without swinging.
double largest_kick(const std::vector<TimedPoint>& path, const Vec3& normal, double until, double quarter) {
  double out = 0;
  for (double t = 0; t <= until + quarter; t += 0.1 * quarter)
    out = std::max(out, std::abs(along(path, normal, t + quarter) - 2 * along(path, normal, t) +
                                 along(path, normal, t - quarter)));
  return out / quarter;
}

}  // namespace

std::optional<BodySwing> find_swing(const DeformableModel& model, const State& state, const VectorX& push) {
  const int n = model.mesh().num_nodes();
  if (still_nodes(model).empty() || model.mesh().num_own_nodes() > kSwingNodes) return {};
  StepMatrix matrix(make_free_dofs(n, model.fixed_nodes()));
  const FreeDofs& dofs = matrix.dofs();
  if (dofs.size() == 0) return {};
  const Tangent tangent = model.tangent(state, TangentKind::definite);
  const SparseMatrix stiffness = matrix.sum({{{0, &model.mass()}, {0, &tangent.dfdv}, {-1, &tangent.dfdx}}});
  const SparseMatrix mass = gather(dofs, model.mass());
  const auto solver = make_step_solver("automatic", {free_positions(model, dofs), 1e-4});
  const VectorX force = gather(dofs, push);
  VectorX u = VectorX::Zero(dofs.size());
  if (!solver->solve(stiffness, force, u)) return {};
  const double yields = force.dot(u);
  if (!(yields > 0)) return {};
  for (int i = 0; i < kIterations; ++i) {
    const VectorX inertia = mass * (u / std::sqrt(u.dot(mass * u)));
    if (!solver->solve(stiffness, inertia, u)) return {};
  }
  u /= std::sqrt(u.dot(mass * u));
  const double omega = std::sqrt(u.dot(stiffness * u));
  const double damping = -u.dot(gather(dofs, tangent.dfdv) * u);
  if (!(omega > 0) || !std::isfinite(omega)) return {};
  return BodySwing{omega, damping / (2 * omega), std::pow(u.dot(force) / omega, 2) / yields};
}

double backward_euler_damping(double omega, double dt) {
  const double turn = omega * dt;
  return turn > 0 ? std::log(std::hypot(1, turn)) / std::hypot(std::atan(turn), std::log(std::hypot(1, turn))) : 0;
}

/// A hand is left out: how fast it presses is not known before.
void predict_swing(const BuiltScene& built, std::vector<Prediction>& out) {
  const Scene& scene = built.scene();
  const bool is_backward = scene.global.integrator == "implicit_euler" || scene.global.integrator == "newton_euler";
  if (!is_backward || built.path().size() < 2 || scene.tool.path.hand) return;
  const Deepest deepest = find_deepest(built);
  if (deepest.triangle < 0) return;
  const Triangle& t = built.surface().triangles[static_cast<std::size_t>(deepest.triangle)];
  const Vec3 inwards = -area_of(built.start().x, t).normalized();
  VectorX push = VectorX::Zero(built.start().x.size());
  moved_by(built.surface(), {}, deepest.triangle, Vec3::Constant(1.0 / 3)).add_to(push, inwards);
  const auto swing = find_swing(built.model(), built.start(), push);
  if (!swing || swing->share < kMostly || swing->zeta > kSwings) return;
  const double quarter = 0.5 * std::numbers::pi / swing->omega;
  if (deepest.t > 1e4 * quarter) return;  // a long way: not looked at in such steps
  const double kick = largest_kick(built.path(), inwards, deepest.t, quarter);
  const double height = swing->share * std::min(1.0, kick / (swing->omega * deepest.depth));
  const double numerical = backward_euler_damping(swing->omega, 1 / scene.global.rate_hz);
  if (height < kFelt || numerical < swing->zeta) return;
  std::vector<Cure> cures;
  if (!scene.global.self_contact)  // its steps are backward Euler's
    cures.push_back(set_to("global.integrator", "sdirk2",
                           told("a third of the error less for three times the work of a global step, with "
                                "global.rate_hz ",
                                2 * scene.global.rate_hz, " half of it")));
  out.push_back({"swing", Finding{told("global.integrator ", scene.global.integrator,
                                       ": under the tool the body swings as a whole at ",
                                       with_digits(swing->omega / (2 * std::numbers::pi), 2), " Hz; steps of ",
                                       with_digits(1e3 / scene.global.rate_hz, 3), " ms damp that by ",
                                       with_digits(numerical, 2), " of what is critical, the body itself by ",
                                       with_digits(swing->zeta, 2), ": the force swings less than it should"),
                                  cures}
                              .at("global.integrator", numerical, swing->zeta)});
}

}  // namespace kt
