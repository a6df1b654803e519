#include "haptics/refresh/touch_ranges.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "core/base/ranges.hpp"
#include "io/scene/key_facts.hpp"

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

}  // namespace

void check_ranges(const TouchOptions& o) {
  for (std::size_t k = 0; k < o.tools.size(); ++k) check_tool(o.tools[k], k == 0 ? "tool" : "second_tool");
  require_limits("contact", o.contact);
  if (o.contact.mu_kinetic > o.contact.mu_static)
    throw InputError(text("contact.mu_kinetic is ", o.contact.mu_kinetic, ", must be at most contact.mu_static, ",
                          o.contact.mu_static));
  require_limits("local", o.local);
  require_limits("global", o.global);
  require_limits("link", o.link);
  require_within({{.key = "stale_s", .value = o.stale_s, .above = true}});
  if (o.global.rate_hz > o.local.rate_hz)
    throw InputError(
        text("global.rate_hz is ", o.global.rate_hz, ", must be at most local.rate_hz, ", o.local.rate_hz));
}

}  // namespace kt
