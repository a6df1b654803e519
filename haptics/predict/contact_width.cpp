#include "haptics/predict/contact_width.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "collision/shape/closest_point.hpp"
#include "haptics/setup/built_scene.hpp"

namespace kt {
namespace {

/// factor = limit + c ratio^p. Measured: tet4 1.28, 2.02, 4.17 at ratios 0.72, 1.44, 2.89; tet10 1.10, 1.42, 1.87 at
/// 1.15, 1.92, 2.89; springs 0.82, 1.26, 2.70 at 0.72, 1.44, 2.89. Springs have no continuum to converge to: under a
/// small tool they give way by turning.
struct Law {
  double limit, c, p;
};

std::optional<Law> law_of(const std::string& element) {
  if (element == "msd") return Law{0.7, 0.25, 1.95};
  if (element == "tet4") return Law{1, 0.51, 1.72};
  if (element == "tet10") return Law{1, 0.085, 2.2};
  return {};
}

/// The smooth surface is stiffer on the same nodes: tet4 2.59 instead of 2.04, springs 1.59 instead of 1.27, at 1.43.
constexpr double kSmooth = 0.18;

std::string element_of(const BuiltScene& built) {
  const ModelInfo info = built.model().info();
  if (info.type == "fem") return built.scene().object.model.element;
  return info.parameters.contains("calibration_residual") ? info.type : "";  // its springs mean no material
}

double force_factor(const BuiltScene& built, double ratio) {
  const double factor = coarse_force_factor(element_of(built), ratio);
  return built.scene().contact.surface == "flat" ? factor : factor * (1 + kSmooth * ratio);
}

/// Three digits.
std::string short_number(double value) {
  char out[32];
  std::snprintf(out, sizeof out, "%.3g", value);
  return out;
}

/// Of a file of these kinds the surface is split and filled, as the scene says.
bool is_surface(const Scene& scene) {
  const std::string& file = scene.object.mesh;
  return !scene.object.layers && std::ranges::any_of(std::array{".obj", ".off", ".ply", ".stl"},
                                                     [&](const char* end) { return file.ends_with(end); });
}

/// Depth of a ball below the surface, and the triangle that it is nearest to.
struct Pressed {
  double depth = 0;
  int triangle = -1;
};

Pressed pressed_in(const VectorX& x, const std::vector<Triangle>& triangles, const Vec3& place, double radius) {
  ClosestPoint nearest{.distance_sq = std::numeric_limits<double>::infinity()};
  Pressed out;
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const Triangle& t = triangles[i];
    const ClosestPoint at = closest_point_on_triangle(place, node(x, t[0]), node(x, t[1]), node(x, t[2]));
    if (!(at.distance_sq < nearest.distance_sq)) continue;
    nearest = at;
    out.triangle = static_cast<int>(i);
  }
  if (out.triangle < 0) return out;
  const Triangle& t = triangles[static_cast<std::size_t>(out.triangle)];
  const Vec3 a = node(x, t[0]), normal = (node(x, t[1]) - a).cross(node(x, t[2]) - a);
  const double distance = std::sqrt(nearest.distance_sq);
  out.depth = radius - (normal.dot(place - nearest.point) < 0 ? -distance : distance);
  return out;
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

double coarse_force_factor(const std::string& element, double ratio) {
  const auto law = law_of(element);
  return law ? law->limit + law->c * std::pow(ratio, law->p) : std::numeric_limits<double>::quiet_NaN();
}

double ratio_of_factor(const std::string& element, double factor) {
  const auto law = law_of(element);
  return law ? std::pow(std::max(0.0, factor - law->limit) / law->c, 1 / law->p)
             : std::numeric_limits<double>::quiet_NaN();
}

bool is_off(const ContactWidth& w) { return w.factor > kCoarseForce || w.factor < 1 / kCoarseForce; }

std::optional<ContactWidth> find_contact_width(const BuiltScene& built, std::span<const Vec3> places) {
  constexpr double kWork = 1e6;  // closest points: below a tenth of a second
  const std::vector<Triangle>& triangles = built.surface().triangles;
  const VectorX& x = built.start().x;
  const ToolShape& tool = built.tool();
  if (tool.kind != ToolShape::Kind::sphere || places.empty() || triangles.empty()) return {};
  const auto most = static_cast<std::size_t>(std::clamp(kWork / static_cast<double>(triangles.size()), 8.0, 200.0));
  const std::size_t stride = std::max<std::size_t>(1, places.size() / most);
  std::vector<Pressed> pressed;
  for (std::size_t i = 0; i < places.size(); i += stride)
    pressed.push_back(pressed_in(x, triangles, places[i], tool.radius));
  const double deepest = std::ranges::max(pressed, {}, &Pressed::depth).depth;
  if (!(deepest > 0)) return {};
  const VectorX area = area_at_nodes(x, triangles);
  ContactWidth out{.least = std::numeric_limits<double>::infinity(), .factor = 0};
  int count = 0;
  for (const Pressed& p : pressed) {
    if (p.depth < 0.5 * deepest) continue;
    const Triangle& t = triangles[static_cast<std::size_t>(p.triangle)];
    const double cell = std::sqrt(2 * (area[t[0]] + area[t[1]] + area[t[2]]) / 3);
    const double contact = std::sqrt(tool.radius * std::min(p.depth, tool.radius)), ratio = cell / contact;
    ++count;
    out.cell += cell;
    out.contact_radius += contact;
    out.mean += ratio;
    out.least = std::min(out.least, ratio);
    out.most = std::max(out.most, ratio);
    out.factor += force_factor(built, ratio);
  }
  for (double* sum : {&out.cell, &out.contact_radius, &out.mean, &out.factor}) *sum /= count;
  const bool are_springs = element_of(built) == "msd";  // right at one size only
  out.fine_edge = ratio_of_factor(element_of(built), are_springs ? 1 : kCoarseForce) * out.contact_radius;
  return out;
}

std::string coarse_mesh_warning(const BuiltScene& built, const ContactWidth& width) {
  const std::string element = element_of(built);
  std::string out = text("object.mesh: cells of ", short_number(1e3 * width.cell), " mm under a contact of ",
                         short_number(2e3 * width.contact_radius), " mm across: expect about ",
                         short_number(width.factor), " times the force of the continuum (", element, "); ");
  if (width.factor < 1) return out + "set object.model.type to fem and object.model.element to tet10";
  if (element == "tet4")
    out += text("set object.model.element to tet10 (about ", short_number(coarse_force_factor("tet10", width.mean)),
                " times), or ");
  if (is_surface(built.scene()))
    return out + text("set object.tetrahedralize.max_edge to ", short_number(width.fine_edge), " m");
  return out + text("take a mesh with cells below ", short_number(1e3 * width.fine_edge), " mm under the tool");
}

}  // namespace kt
