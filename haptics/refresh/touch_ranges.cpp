#include "haptics/refresh/touch_ranges.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "core/base/ranges.hpp"

namespace kt {
namespace {

void check_tool(const TouchTool& tool, const std::string& name) {
  const ToolShape& shape = tool.shape;
  const bool has_core = shape.kind == ToolShape::Kind::capsule || shape.kind == ToolShape::Kind::mesh;
  if (shape.kind != ToolShape::Kind::point)
    require_within({{.key = name + ".radius", .value = shape.radius, .most = 10, .above = true}});
  if (!(tool.max_speed >= 0))  // 0: of a path that stands still
    throw InputError(text(name, ".max_speed is ", tool.max_speed, ", must be at least 0 [m/s]"));
  if (has_core && shape.corners.empty())
    throw InputError(text(name, ": a capsule or a mesh has corners; make_capsule() and make_mesh_tool() give them"));
  if (!std::ranges::all_of(shape.corners, [](const Vec3& c) { return c.allFinite(); }))
    throw InputError(text(name, ": a corner is not finite"));
  const auto corners = static_cast<int>(shape.corners.size());
  for (const Triangle& t : shape.triangles)
    for (const int i : t)
      if (i < 0 || i >= corners)
        throw InputError(text(name, ": a triangle has corner ", i, ", must be 0 .. ", corners, " - 1"));
}

void check_contact(const ContactSettings& c) {
  require_within({{.key = "contact.mu_static", .value = c.mu_static, .most = 100},
                  {.key = "contact.mu_kinetic", .value = c.mu_kinetic, .most = 100},
                  {.key = "contact.penalty.stiffness", .value = c.penalty.stiffness, .most = 1e6, .above = true},
                  {.key = "contact.penalty.damping", .value = c.penalty.damping, .most = 1e5},
                  {.key = "contact.stribeck", .value = c.stribeck, .most = 100},
                  {.key = "contact.surface_levels", .value = double(c.surface_levels), .least = 1, .most = 4},
                  {.key = "contact.ridge_deg", .value = c.ridge_deg, .most = 180}});
  if (c.mu_kinetic > c.mu_static)
    throw InputError(
        text("contact.mu_kinetic is ", c.mu_kinetic, ", must be at most contact.mu_static, ", c.mu_static));
}

}  // namespace

void check_ranges(const TouchOptions& o) {
  for (std::size_t k = 0; k < o.tools.size(); ++k) check_tool(o.tools[k], k == 0 ? "tool" : "second_tool");
  check_contact(o.contact);
  require_within(
      {{.key = "local.rate_hz", .value = o.local.rate_hz, .least = 10, .most = 1e6},
       {.key = "local.rings", .value = double(o.local.rings), .least = 1, .most = 100},
       {.key = "local.tolerance", .value = o.local.tolerance, .most = 10, .above = true},
       {.key = "local.budget_us", .value = o.local.budget_us, .most = 1e6, .above = true},
       {.key = "local.blend_ms", .value = o.local.blend_ms, .most = 1000},
       {.key = "local.fineness", .value = o.local.fineness, .least = 0.3, .most = 2},
       {.key = "local.refine_nodes", .value = static_cast<double>(o.local.refine_nodes), .least = 100, .most = 5000},
       {.key = "local.passivity_damping", .value = o.local.passivity_damping, .most = 1e5},
       {.key = "global.rate_hz", .value = o.global.rate_hz, .most = 1e5, .above = true},
       {.key = "global.tolerance", .value = o.global.tolerance, .most = 0.1, .above = true},
       {.key = "link.latency_ms", .value = o.link.latency_ms, .most = 60000},
       {.key = "link.loss", .value = o.link.loss, .most = 1},
       {.key = "link.stale_ms", .value = o.link.stale_ms, .least = 20, .most = 60000},
       {.key = "link.basis_bits", .value = double(o.link.basis_bits), .least = 8, .most = 16},
       {.key = "stale_s", .value = o.stale_s, .above = true}});
  if (o.local.refresh_budget_ms)
    require_within(
        {{.key = "local.refresh_budget_ms", .value = *o.local.refresh_budget_ms, .most = 1e5, .above = true}});
  if (o.link.refresh_ms) require_within({{.key = "link.refresh_ms", .value = *o.link.refresh_ms, .most = 60000}});
  if (o.global.rate_hz > o.local.rate_hz)
    throw InputError(
        text("global.rate_hz is ", o.global.rate_hz, ", must be at most local.rate_hz, ", o.local.rate_hz));
}

}  // namespace kt
