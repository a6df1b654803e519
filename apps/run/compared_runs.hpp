#pragma once
// Runs beside each other: what was set otherwise, how far the forces are apart, would a person notice.
#include <array>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/types.hpp"

namespace kt {

/// What `kilotouch compare` reads of one result folder.
struct ComparedRun {
  std::string folder, name;
  nlohmann::ordered_json scene, summary;
  std::vector<std::pair<std::string, std::string>>
      live;      ///< setting that was changed while it ran, "0.9 at 1.2 s; ..."
  double h = 0;  ///< [s] of a tick
  struct Tool {
    std::vector<Vec3> force, place;  ///< on it [N], and where it was [m], one a tick
  };
  std::vector<Tool> tools;  ///< 1 or 2
};

/// Throws InputError: no such folder, no run in it, a file that is damaged.
ComparedRun read_run(const std::string& folder);

/// A setting that is not the same in all runs; null where a run has none of that name. One that was changed while a run
/// went on has a row of its own, "contact.mu while it ran".
struct ChangedSetting {
  std::string key;
  std::vector<nlohmann::ordered_json> values;  ///< one a run
};
std::vector<ChangedSetting> changed_settings(const std::vector<ComparedRun>& runs);

/// not_judged: the runs have no contact in common.
enum class Noticed { no, perhaps, yes, not_judged };

struct ForceDifference {
  // A person tells two forces apart that differ by 7 to 10 % (docs/methods.md).
  static constexpr double kPerhaps = 0.07, kSurely = 0.10;
  static constexpr double kShortest = 0.01;  ///< of the ticks in contact: less is one jerk, which `largest` tells

  double seconds = 0;                               ///< that both have
  double rms_n = 0, rms_share = 0;                  ///< [N], and of the first run's root mean square
  double largest_n = 0, largest_share = 0, at = 0;  ///< [N], of the first run's largest force, when [s]
  double perhaps_share = 0, surely_share = 0;       ///< of the ticks with a force, those beyond 7 and 10 % of it
  double common_contact = 0;                        ///< in which both have a force [s]
  double apart = 0;                                 ///< largest distance of the tools [m]
  bool same_bits = false;                           ///< every force the same double
  Noticed noticed = Noticed::no;
};

/// Of a tool that both have, of `other` against `first`, at the ticks of `first`; linear in between where the rates
/// differ. A tick is judged by its percentage where either force is above kForceFloor (haptics/session/metrics.hpp) of
/// the first run's root mean square; where both are in no tick, nothing is judged.
ForceDifference compare_runs(const ComparedRun& first, const ComparedRun& other, std::size_t tool = 0);

}  // namespace kt
