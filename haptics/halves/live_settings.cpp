#include "haptics/halves/live_settings.hpp"

#include <cmath>

#include "core/base/error.hpp"
#include "core/local/contact_surface.hpp"
#include "haptics/refresh/reducer_candidates.hpp"

namespace kt {
namespace {

#define NUMBER(field) [](LiveValues v) -> double* { return &v.field; }, nullptr
#define WORD(field) nullptr, [](LiveValues v) -> std::string* { return &v.field; }

const LiveSetting kSettings[] = {
    {"contact.mu", Renews::friction, 0, 100, false, NUMBER(touch.contact.mu_static)},
    {"contact.mu_static", Renews::friction, 0, 100, false, NUMBER(touch.contact.mu_static)},
    {"contact.mu_kinetic", Renews::friction, 0, 100, false, NUMBER(touch.contact.mu_kinetic)},
    {"contact.stribeck", Renews::friction, 0, 100, false, NUMBER(touch.contact.stribeck)},
    {"tool.radius", Renews::radius, 0, 10, true, NUMBER(touch.tools[0].shape.radius)},
    {"object.model.young", Renews::model, 0, 1e13, true, NUMBER(material.young)},
    {"object.model.damping.mass", Renews::model, 0, 1e6, false, NUMBER(material.damping.mass)},
    {"object.model.damping.stiffness", Renews::model, 0, 1000, false, NUMBER(material.damping.stiffness)},
    {"global.rate_hz", Renews::refresher, 0, 100000, true, NUMBER(touch.global.rate_hz)},
    {"local.tolerance", Renews::refresher, 0, 10, true, NUMBER(touch.local.tolerance)},
    {"local.reducer", Renews::refresher, 0, 0, false, WORD(touch.local.reducer)},
    {"contact.surface", Renews::refresher, 0, 0, false, WORD(touch.contact.surface)},
};

#undef NUMBER
#undef WORD

}  // namespace

std::span<const LiveSetting> live_settings() { return kSettings; }

const LiveSetting& live_setting(const std::string& key) {
  std::vector<std::string> known;
  for (const LiveSetting& s : kSettings) {
    if (key == s.key) return s;
    known.emplace_back(s.key);
  }
  const std::string near = nearest_name(key, known);
  throw InputError(text(key, ": cannot be changed while the body is touched; ",
                        near.empty() ? "" : text("did you mean ", near, "? "), "can be: ", join(known)));
}

void change_setting(const SettingChange& change, LiveValues values) {
  const LiveSetting& s = live_setting(change.key);
  if (s.word) {
    if (change.key == "local.reducer") require_backend(change.key, change.word, reducer_names());
    if (change.key == "contact.surface") require_backend(change.key, change.word, contact_surface_backends());
    *s.word(values) = change.word;
    return;
  }
  const double value = change.value;
  if (!change.word.empty()) throw InputError(text(change.key, " is \"", change.word, "\", must be a number"));
  if (!(std::isfinite(value) && value <= s.most && (s.above ? value > s.least : value >= s.least)))
    throw InputError(
        text(change.key, " is ", value, ", must be ", s.above ? "above " : "at least ", s.least, ", at most ", s.most));
  if (change.key == "global.rate_hz" && value > values.touch.local.rate_hz)
    throw InputError(
        text("global.rate_hz is ", value, ", must be at most local.rate_hz, ", values.touch.local.rate_hz));
  ContactSettings& contact = values.touch.contact;
  if (change.key == "contact.mu_kinetic" && value > contact.mu_static)
    throw InputError(text("contact.mu_kinetic is ", value, ", must be at most contact.mu_static, ", contact.mu_static));
  if (s.renews == Renews::radius && values.touch.tools[0].shape.kind == ToolShape::Kind::point)
    throw InputError("tool.radius: a point has none");
  *s.number(values) = value;
  if (change.key == "contact.mu") contact.mu_kinetic = value;
  contact.mu_kinetic = std::min(contact.mu_kinetic, contact.mu_static);
}

}  // namespace kt
