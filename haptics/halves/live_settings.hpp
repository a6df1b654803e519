#pragma once
// The settings that may change while a body is touched: one table.
#include <span>

#include "haptics/options/touch_options.hpp"
#include "io/scene/scene.hpp"

namespace kt {

/// What they are changed in.
struct LiveValues {
  TouchOptions& touch;
  SceneModel& material;
};

/// What a change asks for besides.
enum class Renews { friction, radius, refresher, model };

struct LiveSetting {
  const char* key;
  Renews renews;
  double least, most;             ///< as in the scene's schema; names: not used
  bool above;                     ///< `least` itself is not allowed
  double* (*number)(LiveValues);  ///< null: it is a name
  std::string* (*word)(LiveValues);
};

std::span<const LiveSetting> live_settings();

/// Throws InputError: no such setting, or none that can change while the body is touched.
const LiveSetting& live_setting(const std::string& key);

/// The change in values that were checked; the friction coefficients stay in order: mu_kinetic follows mu_static down.
/// Throws InputError: what, value, allowed range. Nothing is changed then.
void change_setting(const SettingChange& change, LiveValues values);

}  // namespace kt
