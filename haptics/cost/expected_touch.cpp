#include "haptics/cost/expected_touch.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "collision/held/surface_contacts.hpp"
#include "core/base/percentile.hpp"
#include "core/fine/fine_refinement.hpp"
#include "core/fine/fine_size.hpp"
#include "haptics/tick/apron_window.hpp"

namespace kt {
namespace {

constexpr double kPi = 3.14159265358979323846;

double disc(double radius) { return kPi * radius * radius; }

Triangle sorted(Triangle t) {
  std::ranges::sort(t);
  return t;
}

/// Sizes of the cells that have a face among these triangles, by its corners.
std::map<Triangle, double> cell_sizes(const Mesh& mesh, const Surface& surface, const SurfacePatch& patch) {
  std::map<Triangle, double> out;
  for (const int t : patch.global_triangle) out.emplace(sorted(surface.triangles[t]), 0);
  for (const Tetrahedron& t : mesh.tetrahedra)
    for (const Triangle& face :
         {Triangle{t[0], t[1], t[2]}, {t[0], t[1], t[3]}, {t[0], t[2], t[3]}, {t[1], t[2], t[3]}})
      if (const auto found = out.find(sorted(face)); found != out.end())
        found->second = leaf_size({node(mesh.x, t[0]), node(mesh.x, t[1]), node(mesh.x, t[2]), node(mesh.x, t[3])});
  return out;
}

/// A triangle that is no cell's face stands for a cell whose half face it is.
std::vector<SurfaceCell> surface_cells(const Mesh& mesh, const Surface& surface, const SurfacePatch& patch) {
  const std::map<Triangle, double> sizes = cell_sizes(mesh, surface, patch);
  std::vector<SurfaceCell> out;
  for (const int t : patch.global_triangle) {
    const Triangle& v = surface.triangles[t];
    const Vec3 a = node(mesh.x, v[0]);
    const double area = 0.5 * (node(mesh.x, v[1]) - a).cross(node(mesh.x, v[2]) - a).norm(), size = sizes.at(sorted(v));
    out.push_back({area, size > 0 ? size : std::sqrt(2 * area)});
  }
  return out;
}

double total_area(std::span<const SurfaceCell> cells) {
  double out = 0;
  for (const SurfaceCell& cell : cells) out += cell.area;
  return out;
}

/// How large refined cells may be under a contact [m].
double largest_leaf(const TouchOptions& options, double contact_radius) {
  constexpr double kOfTwo = 1.4;
  return (options.tools.size() > 1 ? kOfTwo : 1) * std::max(kLeastFineness, options.local.fineness) * contact_radius;
}

/// Whether a tool meets the patch's rim before the next refresh, as one does that moves fast over small triangles: the
/// patch is then no larger than its contact.
bool meets_rim(const TouchOptions& options, const TouchTool& tool, const ContactSite& site, double triangle) {
  constexpr double kMargin = 1.1, kHand = 0.1;  // of the tool's reach; [m/s] of one without a bound
  constexpr double kMoved = 3;                  // the tool, and the surface twice: it may be on both sides
  const double way = std::min(tool.max_speed, kHand) / options.global.rate_hz;
  return kMargin * tool_reach(tool.shape) + kMoved * way >= site.reach + 0.5 * std::sqrt(2 * triangle);
}

}  // namespace

double expected_contact_radius(const ToolShape& shape) {
  return 0.25 * std::max(shape.radius, 0.3 * tool_reach(shape));
}

double pressed_contact_radius(const ToolShape& shape, double depth) {
  const double radius = std::max(shape.radius, 0.3 * tool_reach(shape));
  if (!(depth > 0)) return expected_contact_radius(shape);
  return std::sqrt(radius * std::min(depth, radius));
}

double expected_places(double contact_radius, double triangle) {
  constexpr double kFlat = 0.55;  // of the triangles: the others lie too low
  return 1 + (triangle > 0 ? kFlat * disc(contact_radius) / triangle : 0);
}

double expected_nodes(double contact_radius, std::span<const SurfaceCell> cells, double leaf) {
  const double all = total_area(cells);
  if (!(all > 0) || !(leaf > 0)) return 0;
  double nodes = 0;
  for (const SurfaceCell& cell : cells)
    nodes += 2 * std::pow(4, std::max(0.0, std::ceil(std::log2(cell.size / leaf) - 1e-9)));
  return disc(contact_radius) * nodes / all;
}

ExpectedTouch expect_touch(const TouchOptions& options, const Mesh& mesh, const Surface& surface,
                           const SurfacePatch& patch, const ContactSite& site, const ExpectedTouch& kind) {
  constexpr double kRefinedRim = 0.7;  // of the ticks: where many places are held the patch is as small as the contact
  constexpr double kOnScan = 20;       // FineZoneOptions::apart
  constexpr int kSeen = 3;   // places, from which on a contact's radius is measured, and the patch fitted to it
  constexpr int kAdded = 4;  // of a tool's share of kMaxContacts, kept for places that are pushed at
  ExpectedTouch out;
  if (options.local.method != "multirate") return out;
  const bool refines = out.is_refined = kind.is_refined;
  out.is_projected = kind.is_projected;
  const std::vector<SurfaceCell> cells = surface_cells(mesh, surface, patch);
  const double triangle = cells.empty() ? 0 : total_area(cells) / static_cast<double>(cells.size());
  double rim = refines ? kRefinedRim : 0;
  for (const TouchTool& tool : options.tools) {
    const double radius = pressed_contact_radius(tool.shape, options.press_depth);
    double places = expected_places(radius, triangle);
    if (tool.shape.kind == ToolShape::Kind::point || out.is_projected) places = 1;
    if (refines && surface.embedded) places = kOnScan;
    if (refines && !surface.embedded) places = expected_nodes(radius, cells, largest_leaf(options, radius));
    const double most = kMaxContacts / static_cast<double>(options.tools.size()) - kAdded;
    out.places += std::clamp(places, 1.0, most);
    out.is_long = out.is_long || tool.shape.kind == ToolShape::Kind::capsule;
    if (!refines && places >= kSeen && meets_rim(options, tool, site, triangle)) rim = 1;
  }
  if (!surface.embedded && !out.is_projected && surface.triangles.size() > patch.triangles.size())
    out.facets = rim * std::min<double>(ApronWindow::kTriangles,
                                        static_cast<double>(surface.triangles.size() - patch.triangles.size()));
  return out;
}

ExpectedTouch seen_touch(ExpectedTouch expected, std::span<const LocalReport> reports, bool is_refined) {
  std::vector<double> places;
  for (const LocalReport& report : reports)
    if (report.count > 0) places.push_back(report.count);
  if (places.empty() || !(expected.places > 0)) return expected;  // no method but multirate has such places
  expected.places = percentile(places, 0.5);
  expected.is_refined = is_refined;
  return expected;
}

}  // namespace kt
