#include "haptics/predict/contact_stiffness.hpp"

#include <algorithm>
#include <cmath>

#include "collision/shape/closest_point.hpp"
#include "core/linear/sparse_solver.hpp"
#include "core/local/subspace.hpp"
#include "haptics/refresh/refresher.hpp"
#include "haptics/session/session.hpp"

namespace kt {
namespace {

/// Of the path's points the one that is furthest inside, and how far; those outside count by their distance.
struct Deepest {
  ContactSite site;
  Vec3 bary = Vec3::Zero(), normal = Vec3::UnitZ();
  double depth = -std::numeric_limits<double>::infinity();  ///< of the tool's surface [m]
};

Deepest find_deepest(const Session& session) {
  const Surface& surface = session.surface();
  const VectorX& x = session.start().x;
  Deepest out;
  for (const TimedPoint& p : session.path()) {
    const ContactSite site = find_contact_site(surface, x, p.x, -1, 0);
    const Triangle& t = surface.triangles[site.triangle];
    const ClosestPoint at = closest_point_on_triangle(p.x, node(x, t[0]), node(x, t[1]), node(x, t[2]));
    const Vec3 n = (node(x, t[1]) - node(x, t[0])).cross(node(x, t[2]) - node(x, t[0])).normalized();
    const double inside = n.dot(site.centre - p.x);
    const double distance = (p.x - site.centre).norm();
    const double depth = session.tool().radius + (inside > 0 ? distance : -distance);
    if (depth > out.depth) out = {site, at.bary, n, depth};
  }
  return out;
}

}  // namespace

std::optional<ContactStiffness> contact_stiffness(const Session& session) {
  if (session.path().empty() || session.model().fixed_nodes().empty()) return {};
  const Deepest at = find_deepest(session);
  if (!(at.depth > 0)) return {};
  const FreeBody body(linearize(session.model(), session.start(), TangentKind::symmetric));
  const auto solver = make_sparse_solver();
  if (!solver->factor(body.stiffness)) return {};
  VectorX force = VectorX::Zero(session.start().x.size());
  const Triangle& t = session.surface().triangles[at.site.triangle];
  for (int i = 0; i < 3; ++i) node(force, t[i]) += at.bary[i] * at.normal;
  const VectorX push = gather(body.dofs, force);
  const VectorX moved = solver->solve(push).col(0);
  const double compliance = push.dot(moved);
  if (!(compliance > 0)) return {};
  const SceneModel& m = session.scene().object.model;
  const double hertz = session.tool().kind == ToolShape::Kind::point
                           ? 0
                           : 2 * m.young / (1 - m.poisson * m.poisson) * std::sqrt(session.tool().radius * at.depth);
  ContactStiffness out;
  out.stiffness = std::max(1 / compliance, m.calibrate || m.type != "msd" ? hertz : 0.0);
  // The share of the load's energy that its damping takes per rate.
  out.damping = out.stiffness * moved.dot(body.damping * moved) / compliance;
  return out;
}

}  // namespace kt
