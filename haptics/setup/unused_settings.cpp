#include "haptics/setup/unused_settings.hpp"

#include "core/base/error.hpp"
#include "core/fine/fine_size.hpp"
#include "haptics/refresh/refresher.hpp"
#include "haptics/tick/haptic_method.hpp"

namespace kt {
namespace {

std::string shown(const std::string& value) { return value; }
std::string shown(bool value) { return value ? "true" : "false"; }
std::string shown(double value) { return text(value); }
std::string shown(int value) { return text(value); }
std::string shown(std::uint64_t value) { return text(value); }
std::string shown(const Vec3& v) { return text('[', v.x(), ", ", v.y(), ", ", v.z(), ']'); }
std::string shown(const std::vector<RegionSettings>& list) { return text("a list of ", list.size()); }
template <class T>
std::string shown(const std::optional<T>& value) {
  return value ? shown(*value) : "none";
}

class Finder {
 public:
  /// @param reason  what was chosen, and what would read the setting
  template <class T>
  void unread(const std::string& key, const T& value, const T& standard, const std::string& reason) {
    if (!(value == standard)) found_.push_back(text(key, " = ", shown(value), " does nothing: ", reason));
  }
  std::vector<std::string> take() { return std::move(found_); }

 private:
  std::vector<std::string> found_;
};

const Scene kDefault;

void look_at_model(const SceneModel& m, Finder& out) {
  const SceneModel& d = kDefault.object.model;
  const std::string key = "object.model.";
  if (m.type != "fem") {
    const std::string reason = text("object.model.type is ", m.type, "; fem reads it");
    out.unread(key + "material", m.material, d.material, reason);
    out.unread(key + "element", m.element, d.element, reason);
    out.unread(key + "consistent_mass", m.consistent_mass, d.consistent_mass, reason);
    out.unread(key + "damping.law", m.damping.law, d.damping.law, reason);
  }
  if (m.type == "fem" && m.material == "linear")
    out.unread(key + "damping.law", m.damping.law, d.damping.law, "object.model.material is linear, the same in both");
  if (m.type != "msd") {
    const std::string reason = text("object.model.type is ", m.type, "; msd reads it");
    out.unread(key + "stiffness", m.stiffness, d.stiffness, reason);
    out.unread(key + "damper", m.damper, d.damper, reason);
    out.unread(key + "least_volume", m.least_volume, d.least_volume, reason);
    if (!m.stiffness) out.unread(key + "calibrate", m.calibrate, d.calibrate, reason);
    return;
  }
  if (m.stiffness) {
    const std::string reason = "object.model.stiffness gives the springs; without it they are calibrated to it";
    out.unread(key + "young", m.young, d.young, reason);
    out.unread(key + "poisson", m.poisson, d.poisson, reason);
  } else {
    out.unread(key + "calibrate", m.calibrate, d.calibrate, "springs without object.model.stiffness are calibrated");
  }
  if (m.damper)
    out.unread(key + "damping.stiffness", m.damping.stiffness, d.damping.stiffness,
               "object.model.damper gives the springs' dampers");
}

/// @param name     of the tool in the scene
/// @param is_read  the velocity of a ball's surface is, by the chosen method and law
void look_at_tool(const SceneTool& tool, const std::string& name, bool is_read, Finder& out) {
  const SceneTool& d = kDefault.tool;
  const std::string reason = text(name, ".shape is ", tool.shape, "; ");
  if (tool.shape == "point") out.unread(name + ".radius", tool.radius, d.radius, reason + "a point has none");
  if (tool.shape != "capsule") out.unread(name + ".length", tool.length, d.length, reason + "capsule reads it");
  if (tool.shape != "mesh") {
    out.unread(name + ".size", tool.size, d.size, reason + "mesh reads it");
    out.unread(name + ".scale", tool.scale, d.scale, reason + "mesh reads it");
  }
  const bool is_round = tool.shape == "point" || tool.shape == "sphere";
  if (is_round) out.unread(name + ".turn", tool.turn, d.turn, reason + "capsule and mesh read it");
  if (tool.shape == "point")
    out.unread(name + ".spin", tool.spin, d.spin, reason + "a ball's surface drags, a point has none");
  else if (is_round && !is_read)
    out.unread(name + ".spin", tool.spin, d.spin,
               "a ball's spin is read by local.method multirate and hold with coulomb");
}

void look_at_contact(const Scene& scene, const std::string& method, Finder& out) {
  const ContactSettings &c = scene.contact, &d = kDefault.contact;
  const std::string law = text("contact.law is ", c.law, "; ");
  if (c.law == "paper_slide" || c.law == "paper_stick") {
    const std::string reason = law + "paper_stick_slip and coulomb have a cone";
    if (c.mu_static > 0) {  // 0 says what is so
      out.unread("contact.mu_static", c.mu_static, d.mu_static, reason);
      out.unread("contact.mu_kinetic", c.mu_kinetic, d.mu_kinetic, reason);
    }
    out.unread("contact.regions", c.regions, d.regions, reason);
  }
  if (c.law == "paper_stick_slip")
    out.unread("contact.mu_kinetic", c.mu_kinetic, c.mu_static, law + "it has one coefficient, mu_static");
  if (is_geometric(c.law)) {
    out.unread("contact.stribeck", c.stribeck, d.stribeck, law + "coulomb reads it");
  } else if (c.mu_static == c.mu_kinetic && c.regions.empty()) {
    out.unread("contact.stribeck", c.stribeck, d.stribeck, "contact.mu_static and mu_kinetic are the same");
  }
  if (method != "penalty") {
    const std::string reason = law + "penalty reads it";
    out.unread("contact.penalty.stiffness", c.penalty.stiffness, d.penalty.stiffness, reason);
    out.unread("contact.penalty.damping", c.penalty.damping, d.penalty.damping, reason);
  }
  if (method == "frozen")
    out.unread("contact.metric", c.metric, d.metric, "local.method is frozen; its compliance is that at rest");
  if (c.surface == "flat") {
    const std::string reason = "contact.surface is flat; loop reads it";
    out.unread("contact.surface_levels", c.surface_levels, d.surface_levels, reason);
    out.unread("contact.ridge_deg", c.ridge_deg, d.ridge_deg, reason);
  }
}

void look_at_global(const Scene& scene, bool catches_up, Finder& out) {
  const GlobalSettings &g = scene.global, &d = kDefault.global;
  const std::string integrator = text("global.integrator is ", g.integrator, "; ");
  if (g.integrator == "symplectic_euler") {
    out.unread("global.solver", g.solver, d.solver, integrator + "it solves nothing");
    out.unread("global.tolerance", g.tolerance, d.tolerance, integrator + "it solves nothing");
  } else if (g.solver == "direct") {
    out.unread("global.tolerance", g.tolerance, d.tolerance, "global.solver is direct; pcg reads it");
  }
  if (g.integrator != "implicit_euler")
    out.unread("global.definite", g.definite, d.definite, integrator + "implicit_euler reads it");
  if (!catches_up)
    out.unread("global.look_ahead", g.look_ahead, d.look_ahead,
               "only what catches up looks ahead: local.method multirate with local.catch_up");
}

void look_at_local(const Scene& scene, const std::string& method, Finder& out) {
  const LocalSettings &l = scene.local, &d = kDefault.local;
  const std::string reducer = text("local.reducer is ", l.reducer, "; ");
  if (l.reducer != "wall") out.unread("local.rings", l.rings, d.rings, reducer + "wall reads it");
  if (l.reducer != "auto") {
    out.unread("local.budget_us", l.budget_us, d.budget_us, reducer + "auto reads it");
    out.unread("local.refresh_budget_ms", l.refresh_budget_ms, d.refresh_budget_ms, reducer + "auto reads it");
  }
  if (l.reducer != "auto" && (method != "multirate" || !scene.global.early_refresh))
    out.unread("local.tolerance", l.tolerance, d.tolerance, reducer + "auto reads it, and global.early_refresh");
  if (method != "multirate") {
    const std::string reason = text("local.method is ", method, "; multirate reads it");
    out.unread("local.catch_up", l.catch_up, d.catch_up, reason);
    out.unread("local.blend_ms", l.blend_ms, d.blend_ms, reason);
  }
  if (l.refine == "off") {
    out.unread("local.fineness", l.fineness, d.fineness, "local.refine is off; auto and follow read it");
    out.unread("local.refine_nodes", l.refine_nodes, d.refine_nodes, "local.refine is off; auto and follow read it");
  } else if (l.fineness < kLeastFineness) {
    out.unread("local.fineness", l.fineness, d.fineness,
               text(kLeastFineness, " is taken: nodes of smaller cells are more places to touch than a tick holds"));
  }
  if (l.refine == "follow") {
    const std::string reason = text("local.refine is ", l.refine, "; the refined cells' own surface is touched");
    out.unread("contact.surface", scene.contact.surface, kDefault.contact.surface, reason);
    out.unread("contact.surface_levels", scene.contact.surface_levels, kDefault.contact.surface_levels, reason);
  }
  const auto yields = [](const SceneTool& tool) { return tool.path.hand || tool.path.device; };
  const bool is_held = yields(scene.tool) || (scene.second_tool && yields(*scene.second_tool));
  if (!is_held)
    out.unread("local.passivity_damping", l.passivity_damping, d.passivity_damping,
               "no tool's path is a hand or a device");
}

void look_at_link(const Scene& scene, Finder& out) {
  const LinkSettings &l = scene.link, &d = kDefault.link;
  if (l.type != "network") {
    out.unread("link.stale_ms", l.stale_ms, d.stale_ms, "link.type is not network");
    out.unread("link.basis_bits", l.basis_bits, d.basis_bits, "link.type is not network");
  }
  if (l.type != "lockstep") {
    const std::string reason = text("link.type is ", l.type, ", as late as it is; lockstep simulates it");
    if (l.type != "network") {
      out.unread("link.loss", l.loss, d.loss, reason);
      out.unread("link.latency_ms", l.latency_ms, d.latency_ms, reason);
    }
    out.unread("link.charge_refreshes", l.charge_refreshes, d.charge_refreshes, reason);
  }
  if (l.type == "thread" || l.loss == 0) out.unread("seed", scene.seed, kDefault.seed, "nothing is random here");
}

}  // namespace

std::vector<std::string> unused_settings(const Scene& scene) {
  const std::string& method = scene.local.method;
  Finder out;
  look_at_model(scene.object.model, out);
  const bool is_read = (method == "multirate" || method == "hold") && !is_geometric(scene.contact.law);
  look_at_tool(scene.tool, "tool", is_read, out);
  if (scene.second_tool) look_at_tool(*scene.second_tool, "second_tool", is_read, out);
  look_at_contact(scene, method, out);
  look_at_global(scene, method == "multirate" && scene.local.catch_up, out);
  look_at_local(scene, method, out);
  look_at_link(scene, out);
  return out.take();
}

}  // namespace kt
