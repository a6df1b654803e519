#pragma once
// Tools and settings of a Touch. No file format, no device, no clock.
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "collision/shape/tool_shape.hpp"
#include "core/base/settings.hpp"

namespace kt {

struct BandPowers;  // haptics/options/band_powers.hpp
struct Scene;       // io/scene/scene.hpp

/// A patch is made for a tool that goes on as fast as it was measured, and a margin for one that gets faster, but for
/// no more than this [m/s]. A faster one touches the apron until the next patch is there.
constexpr double kFollowedSpeed = 0.25;

/// A tool, and a bound of its speed.
struct TouchTool {
  ToolShape shape{ToolShape::Kind::sphere, 0.004};
  double max_speed = std::numeric_limits<double>::infinity();  ///< bound [m/s], where one is known, as of a path
};

/// "auto" went over to another candidate, at the end of the refresh at this tick.
struct ReducerChange {
  int tick = 0;
  std::string from, to;    ///< names of candidates
  std::string why;         ///< in words
  double error = 0;        ///< certified error of the new one, worst of 0-500 Hz, NaN where not known
  double force_error = 0;  ///< expected error of its force
  bool operator==(const ReducerChange&) const = default;
};

/// One refresh, with the ticks of linearization, of the start with the new local model (-1 for a lost one), and of the
/// beginning of its replay.
struct RefreshEvent {
  int linearized_tick = 0, adopted_tick = 0, started_tick = linearized_tick;
  int delay_ticks = -1;     ///< link network, expected age of its local model at adoption, -1 for not told
  std::vector<int> lost{};  ///< ticks before it whose reports never arrived, in two threads or computers, ascending
  bool operator==(const RefreshEvent&) const = default;
};

/// A setting that was changed while the body was touched, from the refresh at that tick on.
struct SettingChange {
  int tick = 0;
  std::string key{};   ///< as in a scene file, "contact.mu"
  double value = 0;    ///< where `word` is empty
  std::string word{};  ///< value of settings that are names
  bool operator==(const SettingChange&) const = default;
};

/// A run to repeat, with the decisions of its clock and its user.
struct TouchReplay {
  std::vector<RefreshEvent> refreshes{};  ///< empty for no replay
  std::optional<std::vector<ReducerChange>> reducer_changes{};
  std::vector<SettingChange> changes{};
};

struct TouchOptions {
  std::vector<TouchTool> tools{TouchTool{}};  ///< 1 to kMaxTools
  ContactSettings contact{};
  GlobalSettings global{};
  LocalSettings local{};
  LinkSettings link{};  ///< type "thread" is Touch::start()
  CollisionSettings collision{};
  std::uint64_t seed = 1;                      ///< seed of the link's losses
  std::shared_ptr<const BandPowers> motion{};  ///< motion that the surface is to follow, as far as it is known before
  double press_depth =
      0;  ///< most that a tool is to be pressed in by [m], as far as it is known before, 0 for not known
  double stale_s = 0.25;  ///< age of a local model from which on frames carry kStaleModel, beyond usual intervals [s]
  TouchReplay replay{};
};

/// Options of a scene. Loads the tools' meshes. Throws InputError for settings that only the tables of several
/// libraries together can judge.
/// @param read_file  gives a file's bytes, the file system by default
TouchOptions touch_options(const Scene& scene,
                           const std::function<std::string(const std::string& path)>& read_file = {});

}  // namespace kt
