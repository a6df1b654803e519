#include "haptics/body/body_ranges.hpp"

#include "core/base/error.hpp"
#include "core/base/ranges.hpp"
#include "io/scene/key_facts.hpp"

namespace kt {
namespace {

void check_body(const BodyOptions& options) {
  const std::string& body = options.object.body;
  if (body != "mesh" && body != "lattice") throw_unknown("object.body", body, {"mesh", "lattice"});
  if (const std::string why = body == "lattice" ? why_no_lattice(options) : ""; !why.empty()) throw InputError(why);
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
  require_limits("object", o.object);
  for (int i = 0; i < 3; ++i)
    require_within({{.key = "object.gravity", .value = o.object.gravity[i], .least = -1e6, .most = 1e6}});
  for (const SceneInclusion& i : o.object.model.inclusions)
    if (!i.center.allFinite()) throw InputError("object.model.inclusions.center: a number is not finite");
  check_body(o);
  require_within({{.key = "contact.ridge_deg", .value = o.ridge_deg, .most = 180}});
  require_limits("global", o.global);
}

}  // namespace kt
