#include "haptics/halves/live_settings.hpp"

#include "core/base/error.hpp"
#include "core/contact_surface/contact_surface.hpp"
#include "haptics/refresh/reducer_candidates.hpp"
#include "io/scene/key_facts.hpp"

namespace kt {
namespace {

#define NUMBER(field) [](LiveValues v) -> double* { return &v.field; }, nullptr
#define WORD(field) nullptr, [](LiveValues v) -> std::string* { return &v.field; }

const LiveSetting kSettings[] = {
    {"contact.mu", Renews::friction, NUMBER(touch.contact.mu_static)},
    {"contact.mu_static", Renews::friction, NUMBER(touch.contact.mu_static)},
    {"contact.mu_kinetic", Renews::friction, NUMBER(touch.contact.mu_kinetic)},
    {"contact.stribeck", Renews::friction, NUMBER(touch.contact.stribeck)},
    {"tool.radius", Renews::radius, NUMBER(touch.tools[0].shape.radius)},
    {"object.model.young", Renews::model, NUMBER(material.young)},
    {"object.model.damping.mass", Renews::model, NUMBER(material.damping.mass)},
    {"object.model.damping.stiffness", Renews::model, NUMBER(material.damping.stiffness)},
    {"global.rate_hz", Renews::refresher, NUMBER(touch.global.rate_hz)},
    {"local.tolerance", Renews::refresher, NUMBER(touch.local.tolerance)},
    {"local.reducer", Renews::refresher, WORD(touch.local.reducer)},
    {"contact.surface", Renews::refresher, WORD(touch.contact.surface)},
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

NumberRange in_range_of(const LiveSetting& setting, double value) {
  static const std::vector<KeyFacts> all = [] {
    std::vector<KeyFacts> out;
    for (const LiveSetting& s : kSettings)
      out.push_back(facts_of(s.key == std::string("contact.mu") ? "contact.mu_static" : s.key));
    return out;
  }();
  const KeyFacts& facts = all[static_cast<std::size_t>(&setting - kSettings)];
  return {.key = setting.key,
          .value = value,
          .least = facts.least,
          .most = facts.most,
          .above = facts.above || setting.renews == Renews::radius,  // 0 is a point's
          .below = facts.below};
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
  require_within({in_range_of(s, value)});
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
