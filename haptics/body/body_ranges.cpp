#include "haptics/body/body_ranges.hpp"

#include "core/base/error.hpp"
#include "core/base/ranges.hpp"
#include "io/solid/lattice.hpp"

namespace kt {
namespace {

void check_shape(const SceneObject& o) {
  if (o.size) require_within({{.key = "object.size", .value = *o.size, .most = 1000, .above = true}});
  if (o.scale) require_within({{.key = "object.scale", .value = *o.scale, .most = 1000, .above = true}});
  if (o.layers)
    require_within({{.key = "object.layers.count", .value = double(o.layers->count), .least = 1, .most = 100},
                    {.key = "object.layers.thickness", .value = o.layers->thickness, .most = 1000, .above = true}});
  if (const auto& t = o.tetrahedralize) {
    require_within({{.key = "object.tetrahedralize.quality", .value = t->quality, .least = 1, .most = 10}});
    for (const auto& [key, value] : {std::pair("max_volume", t->max_volume), std::pair("max_edge", t->max_edge)})
      if (value)
        require_within({{.key = text("object.tetrahedralize.", key), .value = *value, .most = 1000, .above = true}});
  }
  if (const auto& l = o.lattice) {
    if (l->edge) require_within({{.key = "object.lattice.edge", .value = *l->edge, .most = 1000, .above = true}});
    if (l->nodes)
      require_within(
          {{.key = "object.lattice.nodes", .value = double(*l->nodes), .least = 8, .most = kMostLatticeNodes}});
  }
  if (o.fixed.below)
    require_within({{.key = "object.fixed.below.fraction", .value = o.fixed.below->fraction, .most = 1}});
  for (int i = 0; i < 3; ++i)
    require_within({{.key = "object.gravity", .value = o.gravity[i], .least = -1e6, .most = 1e6}});
}

void check_body(const BodyOptions& options) {
  const std::string& body = options.object.body;
  if (body != "mesh" && body != "lattice") throw_unknown("object.body", body, {"mesh", "lattice"});
  if (const std::string why = body == "lattice" ? why_no_lattice(options) : ""; !why.empty()) throw InputError(why);
}

void check_material(const SceneModel& m) {
  require_within(
      {{.key = "object.model.young", .value = m.young, .most = 1e13, .above = true},
       {.key = "object.model.poisson", .value = m.poisson, .least = -1, .most = 0.5, .above = true, .below = true},
       {.key = "object.model.density", .value = m.density, .most = 1e5, .above = true},
       {.key = "object.model.damping.mass", .value = m.damping.mass, .most = 1e6},
       {.key = "object.model.damping.stiffness", .value = m.damping.stiffness, .most = 1000},
       {.key = "object.model.least_volume", .value = m.least_volume, .most = 0.95}});
  if (m.stiffness)
    require_within({{.key = "object.model.stiffness", .value = *m.stiffness, .most = 1e12, .above = true}});
  if (m.damper) require_within({{.key = "object.model.damper", .value = *m.damper, .most = 1e12}});
  for (const SceneInclusion& i : m.inclusions) {
    require_within({{.key = "object.model.inclusions.radius", .value = i.radius, .most = 1000, .above = true},
                    {.key = "object.model.inclusions.stiffer", .value = i.stiffer, .most = 1e6, .above = true}});
    if (!i.center.allFinite()) throw InputError("object.model.inclusions.center: a number is not finite");
  }
}

}  // namespace

std::string why_no_lattice(const BodyOptions& options) {
  const SceneObject& o = options.object;
  if (o.layers) return "object.layers: object.body lattice is filled; leave one of both out";
  if (o.fixed.nodes)
    return "object.fixed.nodes: the nodes of object.body lattice have no numbers of the file; use below or box";
  if (options.global.self_contact)
    return "global.self_contact: not with object.body lattice yet; leave one of both out";
  return "";
}

void check_ranges(const BodyOptions& o) {
  check_shape(o.object);
  check_material(o.object.model);
  check_body(o);
  require_within({{.key = "contact.ridge_deg", .value = o.ridge_deg, .most = 180}});
  if (const auto& s = o.global.self_contact) {
    require_within({{.key = "global.self_contact.mu", .value = s->mu, .most = 100},
                    {.key = "global.self_contact.creep", .value = s->creep, .most = 10, .above = true}});
    if (s->reach) require_within({{.key = "global.self_contact.reach", .value = *s->reach, .most = 1, .above = true}});
    if (s->stiffness)
      require_within({{.key = "global.self_contact.stiffness", .value = *s->stiffness, .most = 1e9, .above = true}});
  }
}

}  // namespace kt
