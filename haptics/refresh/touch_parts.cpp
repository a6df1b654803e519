#include "haptics/refresh/touch_parts.hpp"

#include <cmath>

#include "collision/broad/triangle_index.hpp"
#include "core/global/integrator.hpp"
#include "core/linear/step_solver.hpp"
#include "haptics/refresh/reducer_candidates.hpp"
#include "haptics/refresh/refine_choice.hpp"
#include "haptics/refresh/touch_ranges.hpp"

namespace kt {

std::optional<LocalScheme> local_scheme(const std::string& integrator) {
  if (integrator == "auto") return {};
  if (integrator == "exact") return LocalScheme::exact;
  if (integrator == "symplectic_euler") return LocalScheme::symplectic_euler;
  if (integrator == "implicit_euler") return LocalScheme::implicit_euler;
  throw_unknown("local.integrator", integrator, {"auto", "exact", "implicit_euler", "symplectic_euler"});
}

Metric contact_metric(const std::string& name) {
  if (name == "identity") return Metric::identity;
  if (name == "mass") return Metric::mass;
  if (name == "implicit") return Metric::implicit;
  throw_unknown("contact.metric", name, {"identity", "mass", "implicit"});
}

bool is_geometric(const std::string& contact_law) { return contact_law.rfind("paper", 0) == 0; }

void check_contact_surface(const ContactSettings& contact, const LocalSettings& local) {
  require_backend("contact.surface", contact.surface, contact_surface_backends());
  may_refine(contact, local);
  if (contact.surface == "flat") return;
  const std::string& method = local.method;
  if (method != "multirate" || is_geometric(contact.law))
    throw InputError(text("contact.surface \"", contact.surface, "\" needs local.method \"multirate\" and contact.law ",
                          "\"coulomb\"; local.method \"", method, "\" with contact.law \"", contact.law,
                          "\" touches the triangles: \"flat\""));
}

std::vector<ToolShape> shapes_of(const TouchOptions& options) {
  std::vector<ToolShape> out;
  for (const TouchTool& tool : options.tools) out.push_back(tool.shape);
  return out;
}

double tick_length(const TouchOptions& options) { return 1 / options.local.rate_hz; }

int ticks_per_refresh(const TouchOptions& options) {
  return std::max(1, static_cast<int>(std::llround(options.local.rate_hz / options.global.rate_hz)));
}

std::unique_ptr<HapticMethod> make_method(const TouchOptions& touch, const SurfaceFriction& friction) {
  const ContactSettings& c = touch.contact;
  HapticMethodOptions options;
  options.tools = shapes_of(touch);
  options.h = tick_length(touch);
  options.law = c.law;
  options.friction = friction.everywhere;
  options.friction_of_triangle = friction.of_triangle;
  options.blend = 1e-3 * touch.local.blend_ms;
  options.coupling = {c.penalty.stiffness, c.penalty.damping};
  return make_haptic_method(touch.local.method, options);
}

bool catches_up(const TouchOptions& options) { return options.local.catch_up && options.local.method == "multirate"; }

std::unique_ptr<ContactSolver> catch_up_solver(const TouchOptions& options, const SurfaceFriction& friction) {
  if (!catches_up(options)) return {};
  return make_contact_solver(options.contact.law, friction.everywhere, friction.of_triangle);
}

void check_options(const TouchOptions& o) {
  check_ranges(o);
  require_backend("collision.backend", o.collision.backend, triangle_index_backends());
  require_backend("local.reducer", o.local.reducer, reducer_names());
  require_backend("global.integrator", o.global.integrator, integrator_backends());
  require_backend("global.solver", o.global.solver, step_solver_backends());
  require_backend("contact.law", o.contact.law, contact_solver_backends());
  require_backend("local.method", o.local.method, haptic_method_backends());
  const std::string& method = o.local.method;
  if (o.tools.empty() || o.tools.size() > static_cast<std::size_t>(kMaxTools))
    throw InputError(text("tools: there are ", o.tools.size(), ", must be 1 to ", kMaxTools));
  if (local_scheme(o.local.integrator) == LocalScheme::exact && is_geometric(o.contact.law))
    throw InputError(text("local.integrator \"exact\" is none of the paper's; contact.law \"", o.contact.law,
                          "\" needs symplectic_euler or implicit_euler"));
  TouchOptions one = o;
  one.tools = {TouchTool{}};
  make_method(one, {});
  check_contact_surface(o.contact, o.local);
  if (o.tools.size() > 1 && (method != "multirate" || is_geometric(o.contact.law)))
    throw InputError(text("second_tool: contact.law \"", o.contact.law, "\" with local.method \"", o.local.method,
                          "\" knows one tool; two need local.method multirate with contact.law coulomb"));
  const bool is_round = o.tools[0].shape.corners.empty();
  if (!is_round && (is_geometric(o.contact.law) || method == "frozen" || method == "penalty" || method == "legacy"))
    throw InputError(
        text("tool.shape \"", o.tools[0].shape.kind == ToolShape::Kind::mesh ? "mesh" : "capsule", "\": contact.law \"",
             o.contact.law, "\" with local.method \"", o.local.method,
             "\" knows a point and a sphere; take local.method multirate or hold with contact.law coulomb"));
  if (o.local.method == "legacy" && o.local.reducer != "wall")
    throw InputError(text("local.method \"legacy\" is a framework with a wall: it needs local.reducer \"wall\", not \"",
                          o.local.reducer, "\""));
  if (!is_geometric(o.contact.law) && contact_metric(o.contact.metric) == Metric::identity)
    throw InputError(
        text("contact.metric \"identity\" belongs to the paper's laws (its operators are projectors in "
             "positions); contact.law \"",
             o.contact.law, "\" needs \"mass\" or \"implicit\""));
}

}  // namespace kt
