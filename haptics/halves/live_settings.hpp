#pragma once
// The settings that may change while a body is touched: one table.
#include <span>

#include "core/base/ranges.hpp"
#include "haptics/options/touch_options.hpp"
#include "io/scene/scene.hpp"

namespace kt {

/// What they are changed in.
struct LiveValues {
  TouchOptions& touch;
  SceneModel& material;
};

/// A copy of them, to read from or to try a change in.
struct LiveCopy {
  TouchOptions touch;
  SceneModel material;
  operator LiveValues() { return {touch, material}; }
};

/// What a change asks for besides.
enum class Renews { friction, radius, refresher, model };

/// Its range is that of its key in a scene (io/scene/key_facts.hpp).
struct LiveSetting {
  const char* key;
  Renews renews;
  double* (*number)(LiveValues);  ///< null: it is a name
  std::string* (*word)(LiveValues);
};

std::span<const LiveSetting> live_settings();

/// Throws InputError: no such setting, or none that can change while the body is touched.
const LiveSetting& live_setting(const std::string& key);

/// The value with the range of the setting, a number.
NumberRange in_range_of(const LiveSetting& setting, double value);

/// The change in values that were checked; the friction coefficients stay in order: mu_kinetic follows mu_static down.
/// Throws InputError: what, value, allowed range. Nothing is changed then.
void change_setting(const SettingChange& change, LiveValues values);

}  // namespace kt
