#include <algorithm>
#include <cmath>
#include <limits>

#include "collision/held/surface_contacts.hpp"
#include "collision/shape/closest_point.hpp"
#include "core/body/near_triangles.hpp"
#include "haptics/cells/contact_width.hpp"
#include "haptics/predict/predict.hpp"
#include "haptics/refresh/refine_choice.hpp"
#include "haptics/setup/built_scene.hpp"

namespace kt {
namespace {

/// From the nearest place of the surface at rest [m].
double distance_from_surface(const BuiltScene& built, const Vec3& place) {
  const VectorX& x = built.start().x;
  double least = std::numeric_limits<double>::infinity();
  for_each_near(built.surface(), x, place, least, [&](int i) {
    const Triangle& t = built.surface().triangles[static_cast<std::size_t>(i)];
    least = std::min(least, closest_point_on_triangle(place, node(x, t[0]), node(x, t[1]), node(x, t[2])).distance_sq);
  });
  return std::sqrt(least);
}

/// Triangles that a ball touches where it is deepest: those that it overlaps by half of that or more, as far out as
/// Hertz's contact reaches. Refused where no choice among them holds, of a ball that is as good as a plate: one of a
/// metre on a pad of 60 mm with 200 of them leaps by ten times its force, one of 0.2 m with 70 by a quarter
/// (docs/method.md).
void predict_places(const BuiltScene& built, const std::vector<Vec3>& places, std::vector<Prediction>& out) {
  constexpr double kWork = 1e6, kMostTimes = 2.5;
  const ToolShape& tool = built.tool();
  const std::size_t triangles = built.surface().triangles.size();
  if (tool.kind != ToolShape::Kind::sphere || tool.radius <= 0 || places.empty() || triangles <= kMaxContacts) return;
  const auto most = static_cast<std::size_t>(std::clamp(kWork / static_cast<double>(triangles), 8.0, 200.0));
  const std::size_t stride = std::max<std::size_t>(1, places.size() / most);
  Vec3 deepest = places.front();
  double least = tool.radius;
  for (std::size_t i = 0; i < places.size(); i += stride) {
    const double distance = distance_from_surface(built, places[i]);
    if (distance >= least) continue;
    least = distance;
    deepest = places[i];
  }
  if (least >= tool.radius) return;
  const double depth = tool.radius - least, half = tool.radius - 0.5 * depth;
  const auto touched = std::ranges::count_if(built.surface().triangles, [&](const Triangle& t) {
    const VectorX& x = built.start().x;
    return ((node(x, t[0]) + node(x, t[1]) + node(x, t[2])) / 3 - deepest).norm() <= half;
  });
  if (touched <= kMaxContacts) return;
  const double radius = tool.radius * kMaxContacts / static_cast<double>(touched);  // the area goes as the radius
  const std::string line = told("tool: it touches about ", touched, " triangles of the surface at once, and ",
                                kMaxContacts, " places are resolved: ");
  const Finding found{line + "expect steps of the force, and the tool a little inside",
                      {{"tool.radius", short_number(radius), told("set tool.radius to ", radius, " or less")},
                       advise("press less deep"),
                       advise("take larger cells")},
                      Finding::Weight::doubt,
                      "tool.radius",
                      static_cast<double>(touched),
                      kMaxContacts};
  const double size = bounds(built.model().mesh()).size().maxCoeff();
  if (static_cast<double>(touched) > kMostTimes * kMaxContacts && tool.radius > 0.5 * size)
    throw InputError(text(line, "its force would leap; ", alternatives(found.cures)));
  if (choose_refine(built.model(), built.surface(), built.options()).refines) return;  // held at refined cells' nodes
  out.push_back({"contact_places", found});
}

/// Cells under the tool are refined whole: of cubes that are far wider than the contact they cannot be made as fine as
/// it within local.refine_nodes, and the force leaps where they are made anew.
void predict_cubes(const BuiltScene& built, double contact_radius, std::vector<Prediction>& out) {
  constexpr double kMost = 4.5;  // seen: 3.8 holds, 4.9 leaps by 80 %
  const auto& surface = built.model().mesh().embedded;
  if (!surface || !(surface->edge > kMost * contact_radius)) return;
  const double ratio = surface->edge / contact_radius;
  const double nodes = built.model().own().mesh().num_nodes() * std::pow(ratio / kMost, 3);
  out.push_back(
      {"contact_width", Finding{told("object.body lattice: cubes of ", 1e3 * surface->edge, " mm are ", ratio,
                                     " contact radii wide (limit ", kMost,
                                     "): refined cells are too large there, the force leaps and the tool may get in"),
                                {set_to("object.lattice.nodes", text(50 * std::ceil(nodes / 50)))}}
                            .at("object.lattice.nodes", ratio, kMost)});
}

}  // namespace

/// A hand gets less deep than its target: its contact is measured after the run.
void predict_contact_width(const BuiltScene& built, std::vector<Prediction>& out) {
  if (built.path().empty() || built.scene().tool.path.hand || built.scene().tool.path.device) return;
  std::vector<Vec3> places;
  for (const TimedPoint& p : built.path())
    if (p.t <= built.scene().duration) places.push_back(p.x);
  predict_places(built, places, out);
  const auto width = find_contact_width(built, places);
  if (width && is_off(*width)) out.push_back({"contact_width", coarse_mesh_finding(built, *width)});
  if (width && width->is_refined && !width->is_line) predict_cubes(built, width->contact_radius, out);
}

}  // namespace kt
