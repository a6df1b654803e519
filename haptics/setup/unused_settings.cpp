#include "haptics/setup/unused_settings.hpp"

#include "core/base/error.hpp"
#include "core/fine/fine_size.hpp"
#include "haptics/refresh/refine_choice.hpp"
#include "haptics/refresh/refresher.hpp"
#include "haptics/tick/haptic_method.hpp"
#include "io/scene/key_facts.hpp"

namespace kt {
namespace {

std::string shown(const std::string& value) { return value; }
std::string shown(bool value) { return value ? "true" : "false"; }
std::string shown(double value) { return text(value); }
std::string shown(int value) { return text(value); }
std::string shown(std::uint64_t value) { return text(value); }
std::string shown(const Vec3& v) { return text('[', v.x(), ", ", v.y(), ", ", v.z(), ']'); }
std::string shown(const std::vector<RegionSettings>& list) { return text("a list of ", list.size()); }

Finding does_nothing(const std::string& key, const std::string& value, const std::string& reason) {
  return {.what = text(key, " = ", value, " does nothing: ", reason), .weight = Finding::Weight::note, .where = key};
}

/// "sphere, capsule and mesh read it".
std::string readers(std::vector<std::string> words) {
  if (words.size() == 1) return words[0] + " reads it";
  const std::string last = words.back();
  words.pop_back();
  return join(words) + " and " + last + " read it";
}

/// What no table of words says.
class Finder {
 public:
  /// @param reason  what was chosen, and what would read the setting
  template <class T>
  void unread(const std::string& key, const T& value, const T& standard, const std::string& reason) {
    if (!(value == standard)) found_.push_back(does_nothing(key, shown(value), reason));
  }
  std::vector<Finding> take() { return std::move(found_); }

 private:
  std::vector<Finding> found_;
};

const Scene kDefault;

void look_at_model(const SceneModel& m, Finder& out) {
  const SceneModel& d = kDefault.object.model;
  const std::string key = "object.model.";
  if (m.type == "fem" && m.material == "linear")
    out.unread(key + "damping.law", m.damping.law, d.damping.law, "object.model.material is linear, the same in both");
  if (m.type != "msd") {
    if (!m.stiffness)
      out.unread(key + "calibrate", m.calibrate, d.calibrate, text("object.model.type is ", m.type, "; msd reads it"));
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
  const bool is_round = tool.shape == "point" || tool.shape == "sphere";
  if (tool.shape == "point")
    out.unread(name + ".spin", tool.spin, d.spin,
               text(name, ".shape is point; a ball's surface drags, a point has none"));
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
  if (method == "frozen")
    out.unread("contact.metric", c.metric, d.metric, "local.method is frozen; its compliance is that at rest");
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
  if (!catches_up)
    out.unread("global.look_ahead", g.look_ahead, d.look_ahead,
               "only what catches up looks ahead: local.method multirate with local.catch_up");
}

void look_at_local(const Scene& scene, const std::string& method, Finder& out) {
  const LocalSettings &l = scene.local, &d = kDefault.local;
  const std::string reducer = text("local.reducer is ", l.reducer, "; ");
  if (l.reducer != "auto" && (method != "multirate" || !scene.global.early_refresh))
    out.unread("local.tolerance", l.tolerance, d.tolerance, reducer + "auto reads it, and global.early_refresh");
  if (l.refine != "off" && l.fineness < kLeastFineness)
    out.unread("local.fineness", l.fineness, d.fineness,
               text(kLeastFineness, " is taken: nodes of smaller cells are more places to touch than a tick holds"));
  if (refines_always(l))
    out.unread("contact.surface_levels", scene.contact.surface_levels, kDefault.contact.surface_levels,
               text("local.refine is ", l.refine, "; refined cells have facets of their own size"));
  const auto yields = [](const SceneTool& tool) { return tool.path.hand || tool.path.device; };
  const bool is_held = yields(scene.tool) || (scene.second_tool && yields(*scene.second_tool));
  if (!is_held)
    out.unread("local.passivity_damping", l.passivity_damping, d.passivity_damping,
               "no tool's path is a hand or a device");
}

void look_at_link(const Scene& scene, Finder& out) {
  const LinkSettings& l = scene.link;
  if (l.type == "thread" || l.loss == 0) out.unread("seed", scene.seed, kDefault.seed, "nothing is random here");
}

}  // namespace

std::vector<Finding> unused_settings(const Scene& scene) {
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
  std::vector<Finding> found;
  for (const UnreadKey& k : unread_keys(scene))
    found.push_back(does_nothing(k.key, k.value, text(k.chooser, " is ", k.chosen, "; ", readers(k.would_be))));
  std::ranges::move(out.take(), std::back_inserter(found));
  return found;
}

}  // namespace kt
