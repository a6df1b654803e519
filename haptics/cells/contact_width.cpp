#include "haptics/cells/contact_width.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "collision/shape/closest_point.hpp"
#include "core/base/types.hpp"
#include "core/body/embedded_surface.hpp"
#include "core/body/near_triangles.hpp"
#include "haptics/cells/mesh_cures.hpp"
#include "haptics/cost/force_factor.hpp"
#include "haptics/refresh/refine_choice.hpp"
#include "haptics/setup/built_scene.hpp"

namespace kt {
namespace {

std::string element_of(const BuiltScene& built) { return fitted_element(built.model().info()); }

double force_factor(const BuiltScene& built, double ratio) {
  return coarse_force_factor(element_of(built), ratio, built.scene().contact.surface != "flat");
}

/// Depth of a ball below the surface, and the triangle that it is nearest to.
struct Pressed {
  double depth = 0;
  int triangle = -1;
};

Pressed pressed_in(const VectorX& x, const Surface& surface, const Vec3& place, double radius) {
  ClosestPoint nearest{.distance_sq = std::numeric_limits<double>::infinity()};
  Pressed out;
  for_each_near(surface, x, place, nearest.distance_sq, [&](int i) {
    const Triangle& t = surface.triangles[static_cast<std::size_t>(i)];
    const ClosestPoint at = closest_point_on_triangle(place, node(x, t[0]), node(x, t[1]), node(x, t[2]));
    if (!(at.distance_sq < nearest.distance_sq)) return;
    nearest = at;
    out.triangle = i;
  });
  if (out.triangle < 0) return out;
  const Triangle& t = surface.triangles[static_cast<std::size_t>(out.triangle)];
  const Vec3 a = node(x, t[0]), normal = (node(x, t[1]) - a).cross(node(x, t[2]) - a);
  const double distance = std::sqrt(nearest.distance_sq);
  out.depth = radius - (normal.dot(place - nearest.point) < 0 ? -distance : distance);
  return out;
}

/// What touches first, as a ball: in the tool's frame [m].
struct Tip {
  Vec3 at = Vec3::Zero();  ///< on the core
  double width = 0;        ///< half of the core's across, at the depth in question, the narrow way
  bool is_edge = false;    ///< it touches along a line
};

/// The core's part that is up to `depth` above its lowest point, against the direction `up`, in the tool's frame.
Tip find_tip(const ToolShape& tool, const Vec3& up, double depth) {
  constexpr double kEdge = 2;      // times longer than wide
  constexpr int kDirections = 12;  // of half a turn
  Tip out;
  if (tool.corners.empty()) return out;
  out.at = *std::ranges::min_element(tool.corners, {}, [&](const Vec3& c) { return c.dot(up); });
  std::array<double, kDirections> low{}, high{};
  const Vec3 u = up.unitOrthogonal(), v = up.cross(u);
  const auto add = [&](const Vec3& p) {
    for (int i = 0; i < kDirections; ++i) {
      const double angle = std::numbers::pi * i / kDirections,
                   x = (p - out.at).dot(std::cos(angle) * u + std::sin(angle) * v);
      low[i] = std::min(low[i], x);
      high[i] = std::max(high[i], x);
    }
  };
  const auto add_edge = [&](const Vec3& a, const Vec3& b) {
    const double from = (a - out.at).dot(up), to = (b - out.at).dot(up);
    if (from <= depth) add(a);
    if (to <= depth) add(b);
    if ((from <= depth) != (to <= depth)) add(a + (depth - from) / (to - from) * (b - a));
  };
  for (const Triangle& t : tool.triangles)
    for (int i = 0; i < 3; ++i) add_edge(tool.corners[t[i]], tool.corners[t[(i + 1) % 3]]);
  if (tool.triangles.empty()) add_edge(tool.corners.front(), tool.corners.back());
  double narrow = std::numeric_limits<double>::infinity(), wide = 0;
  for (int i = 0; i < kDirections; ++i) {
    narrow = std::min(narrow, 0.5 * (high[i] - low[i]));
    wide = std::max(wide, 0.5 * (high[i] - low[i]));
  }
  out.width = narrow;
  const double rounding = std::sqrt(2 * tool.radius * depth);
  out.is_edge = wide + rounding > kEdge * (narrow + rounding);
  return out;
}

/// A tip below the surface, as deep as it is there.
struct PressedTip {
  Pressed pressed;
  double contact = 0;  ///< radius, of a line half its width [m]
  bool is_line = false;
};

PressedTip press_tip(const BuiltScene& built, const Pose& pose) {
  const std::vector<Triangle>& triangles = built.surface().triangles;
  const VectorX& x = built.start().x;
  const ToolShape& tool = built.tool();
  if (tool.corners.empty()) {
    const Pressed p = pressed_in(x, built.surface(), pose.x, tool.radius);
    return {p, std::sqrt(tool.radius * std::clamp(p.depth, 0.0, tool.radius))};
  }
  const auto normal_of = [&](int triangle) {
    const Triangle& t = triangles[static_cast<std::size_t>(triangle)];
    return Vec3((node(x, t[1]) - node(x, t[0])).cross(node(x, t[2]) - node(x, t[0])).normalized());
  };
  const Pressed middle = pressed_in(x, built.surface(), pose.x, tool.radius);
  if (middle.triangle < 0) return {};
  const Vec3 up = pose.r.conjugate() * normal_of(middle.triangle);
  const Tip lowest = find_tip(tool, up, 0);
  const Pressed p = pressed_in(x, built.surface(), pose.x + pose.r * lowest.at, tool.radius);
  if (!(p.depth > 0)) return {p, 0};
  const Tip tip = find_tip(tool, up, p.depth);
  // A ball is sqrt(2 R d) wide at the depth d, and touches over sqrt(R d).
  return {p, tip.width / std::numbers::sqrt2 + std::sqrt(tool.radius * std::min(p.depth, tool.radius)), tip.is_edge};
}

/// Mean area of the triangles at each node [m^2].
VectorX area_at_nodes(const VectorX& x, const std::vector<Triangle>& triangles) {
  VectorX sum = VectorX::Zero(x.size() / 3), count = sum;
  for (const Triangle& t : triangles) {
    const Vec3 a = node(x, t[0]);
    const double area = 0.5 * (node(x, t[1]) - a).cross(node(x, t[2]) - a).norm();
    for (const int v : t) {
      sum[v] += area;
      count[v] += 1;
    }
  }
  return sum.cwiseQuotient(count.cwiseMax(1));
}

}  // namespace

bool is_off(const ContactWidth& w) { return w.factor > kCoarseForce || w.factor < 1 / kCoarseForce; }

bool stays_fine(const BuiltScene& built, const ContactWidth& w, double coarser, const std::string& element) {
  if (w.is_line) return true;  // not known
  const double factor = coarse_force_factor(element.empty() ? element_of(built) : element, coarser * w.mean);
  return !std::isfinite(factor) || factor <= kCoarseForce;
}

namespace {

/// What a tip tells of the cells under the tool.
bool counts(const PressedTip& tip, double deepest) { return tip.pressed.depth >= 0.5 * deepest && tip.contact > 0; }

double factor_at(const BuiltScene& built, const ContactWidth& w, double ratio) {
  if (w.is_line)
    return w.is_refined && built.tool().kind == ToolShape::Kind::capsule ? kRefinedLine
                                                                         : std::numeric_limits<double>::quiet_NaN();
  if (!w.is_refined) return force_factor(built, ratio);
  return refined_force_factor(built.model().info(),
                              std::isfinite(w.fineness) ? w.fineness : built.scene().local.fineness,
                              built.surface().embedded != nullptr);
}

}  // namespace

std::optional<ContactWidth> find_contact_width(const BuiltScene& built, std::span<const Pose> way, double fineness) {
  constexpr double kWork = 1e6;  // closest points: below a tenth of a second
  const std::vector<Triangle>& triangles = built.surface().triangles;
  const VectorX& x = built.start().x;
  const ToolShape& tool = built.tool();
  if (tool.kind == ToolShape::Kind::point || way.empty() || triangles.empty()) return {};
  const auto work = static_cast<double>(2 * triangles.size() + 6 * tool.triangles.size());
  const auto most = static_cast<std::size_t>(std::clamp(2 * kWork / work, 8.0, 200.0));
  const std::size_t stride = std::max<std::size_t>(1, way.size() / most);
  std::vector<PressedTip> tips;
  for (std::size_t i = 0; i < way.size(); i += stride) tips.push_back(press_tip(built, way[i]));
  const double deepest = std::ranges::max(tips, {}, [](const PressedTip& t) { return t.pressed.depth; }).pressed.depth;
  if (!(deepest > 0)) return {};
  const VectorX area = area_at_nodes(x, triangles);
  const RefineChoice choice = choose_refine(built.model(), built.surface(), built.options());
  ContactWidth out{
      .least = std::numeric_limits<double>::infinity(),
      .is_line = std::ranges::all_of(tips, [&](const PressedTip& t) { return t.is_line || !counts(t, deepest); }),
      .is_refined = choice.refines,
      .why_not = choice.why_not,
      .fineness = fineness,
      .factor = 0};
  int count = 0;
  for (const PressedTip& tip : tips) {
    if (!counts(tip, deepest) || tip.is_line != out.is_line) continue;
    const Triangle& t = triangles[static_cast<std::size_t>(tip.pressed.triangle)];
    const auto& embedded = built.surface().embedded;
    const double cell = embedded ? embedded->spacing() : std::sqrt(2 * (area[t[0]] + area[t[1]] + area[t[2]]) / 3);
    const double ratio = cell / tip.contact;
    ++count;
    out.cell += cell;
    out.contact_radius += tip.contact;
    out.mean += ratio;
    out.least = std::min(out.least, ratio);
    out.most = std::max(out.most, ratio);
    out.factor += factor_at(built, out, ratio);
  }
  if (count == 0) return {};
  for (double* sum : {&out.cell, &out.contact_radius, &out.mean, &out.factor}) *sum /= count;
  const bool are_springs = element_of(built) == "msd";  // right at one size only
  if (!out.is_line)
    out.fine_edge = ratio_of_factor(element_of(built), are_springs ? 1 : kCoarseForce) * out.contact_radius;
  return out;
}

std::optional<ContactWidth> find_contact_width(const BuiltScene& built, std::span<const Vec3> places) {
  const std::vector<TimedPose>& poses = built.paths()[0].poses;
  const Quaternion turn = poses.empty() ? rotation(built.scene().tool.turn) : poses.front().pose.r;
  std::vector<Pose> way;
  for (const Vec3& place : places) way.push_back({place, turn});
  return find_contact_width(built, way);
}

namespace {

/// What finer cells cost: a solid of edges half as long has eight times the nodes.
std::string price_of(double finer, double refresh_share) {
  const double nodes = std::pow(std::max(1.0, finer), 3);
  std::string out = told("about ", std::max(2.0, std::round(nodes)), " times the nodes");
  if (refresh_share > 0)
    out += nodes * refresh_share > 1
               ? told(", and no longer in real time: refreshes of ", nodes * refresh_share,
                      " times their interval or more")
               : told(", a refresh then takes ", in_percent(nodes * refresh_share), " of its interval or more");
  return out;
}

/// Whether local.refine auto would refine these cells.
bool auto_refines(const BuiltScene& built) {
  TouchOptions options = built.options();
  options.local.refine = "auto";
  return choose_refine(built.model(), built.surface(), options).refines;
}

}  // namespace

Finding coarse_mesh_finding(const BuiltScene& built, const ContactWidth& width, double refresh_share) {
  const std::string element = element_of(built);
  Finding out{told("object.mesh: ", width.is_refined ? "refined cells of " : "cells of ", 1e3 * width.cell,
                   " mm under a contact of ", 2e3 * width.contact_radius, " mm across: expect about ", width.factor,
                   " times the force of the continuum (", element, ")")};
  out = std::move(out).at("object.mesh", width.factor, 1);
  if (width.is_refined && element == "msd") {  // springs give way more than the material that they stand for
    out.cures.push_back(
        set_to("object.model.type", "fem",
               told("about ", refined_force_factor({"fem", {}, {}}, built.scene().local.fineness), " times")));
    return out;
  }
  if (!width.is_refined && auto_refines(built)) {
    const double factor =
        refined_force_factor(built.model().info(), built.scene().local.fineness, built.surface().embedded != nullptr);
    out.cures.push_back(set_to("local.refine", "auto", told("about ", factor, " times")));
    return out;
  }
  if (width.factor < 1) {
    const std::string to_tet10 = "object.model.element to tet10";
    if (element != "tet10" && !built.surface().embedded)
      out.cures.push_back(
          advise((built.model().info().type == "fem" ? "set " : "set object.model.type to fem and ") + to_tet10));
    return out;
  }
  constexpr double kTet10 = 1.93;  // as much finer are tet4 of as many nodes: a node on each edge
  const bool is_lattice = built.surface().embedded != nullptr;
  if (element == "tet4" && built.model().info().type == "fem" && !is_lattice)
    out.cures.push_back(
        set_to("object.model.element", "tet10",
               told("about ", coarse_force_factor("tet10", width.mean), " times; ", price_of(kTet10, refresh_share))));
  if (element == "tet4" && is_lattice)
    out.cures.push_back(set_to("object.model.element", "hex8",
                               told("about ", coarse_force_factor("hex8", width.mean), " times, as many nodes")));
  const double finer = width.cell / width.fine_edge;
  if (is_lattice)
    out.cures.push_back(
        {"object.lattice.edge", short_number(width.fine_edge),
         told("set object.lattice.edge to ", width.fine_edge, " m (", price_of(finer, refresh_share), ")")});
  else if (fills_surface(built.scene()))
    out.cures.push_back(
        {"object.tetrahedralize.max_edge", short_number(width.fine_edge),
         told("set object.tetrahedralize.max_edge to ", width.fine_edge, " m (", price_of(finer, refresh_share), ")")});
  else
    out.cures.push_back(advise(told("take a mesh with cells below ", 1e3 * width.fine_edge, " mm under the tool (",
                                    price_of(finer, refresh_share), " where it is as fine throughout)")));
  return out;
}

}  // namespace kt
