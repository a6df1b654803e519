#include "haptics/cells/contact_stiffness.hpp"

#include <algorithm>
#include <cmath>

#include "collision/shape/closest_point.hpp"
#include "core/linear/sparse_solver.hpp"
#include "core/local/subspace.hpp"
#include "haptics/refresh/refresher.hpp"
#include "haptics/setup/built_scene.hpp"

namespace kt {
namespace {

/// Of the path's points the one that is furthest inside, and how far; those outside count by their distance.
struct Deepest {
  ContactSite site;
  Vec3 bary = Vec3::Zero(), normal = Vec3::UnitZ();
  double depth = -std::numeric_limits<double>::infinity();  ///< of the tool's surface [m]
};

Deepest find_deepest(const BuiltScene& built) {
  const Surface& surface = built.surface();
  const VectorX& x = built.start().x;
  Deepest out;
  for (const TimedPoint& p : built.path()) {
    const ContactSite site = find_contact_site(surface, x, p.x, -1, 0);
    const Triangle& t = surface.triangles[site.triangle];
    const ClosestPoint at = closest_point_on_triangle(p.x, node(x, t[0]), node(x, t[1]), node(x, t[2]));
    const Vec3 n = (node(x, t[1]) - node(x, t[0])).cross(node(x, t[2]) - node(x, t[0])).normalized();
    const double inside = n.dot(site.centre - p.x);
    const double distance = (p.x - site.centre).norm();
    const double depth = built.tool().radius + (inside > 0 ? distance : -distance);
    if (depth > out.depth) out = {site, at.bary, n, depth};
  }
  return out;
}

}  // namespace

std::optional<ContactStiffness> contact_stiffness(const BuiltScene& built) {
  if (built.path().empty() || still_nodes(built.model()).empty()) return {};
  const Deepest at = find_deepest(built);
  if (!(at.depth > 0)) return {};
  const FreeBody body(linearize(built.model(), built.start(), TangentKind::symmetric));
  const auto solver = make_sparse_solver();
  if (!solver->factor(body.stiffness)) return {};
  VectorX force = VectorX::Zero(built.start().x.size());
  moved_by(built.surface(), {}, at.site.triangle, at.bary).add_to(force, at.normal);
  const VectorX push = gather(body.dofs, force);
  const VectorX moved = solver->solve(push).col(0);
  const double compliance = push.dot(moved);
  if (!(compliance > 0)) return {};
  const SceneModel& m = built.scene().object.model;
  const double hertz = built.tool().kind == ToolShape::Kind::point
                           ? 0
                           : 2 * m.young / (1 - m.poisson * m.poisson) * std::sqrt(built.tool().radius * at.depth);
  ContactStiffness out;
  out.stiffness = std::max(1 / compliance, m.calibrate || m.type != "msd" ? hertz : 0.0);
  // The share of the load's energy that its damping takes per rate.
  out.damping = out.stiffness * moved.dot(body.damping * moved) / compliance;
  return out;
}

}  // namespace kt
