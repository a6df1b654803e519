#pragma once
// Facts found about a scene or a run, for readers of its forces.
#include <optional>
#include <string>
#include <vector>

namespace kt {

/// A setting or an action that ends a finding.
struct Cure {
  std::string key;    ///< the setting of the scene, "global.rate_hz". Empty for no setting
  std::string value;  ///< as `--set key=value` takes it. Empty for several values
  std::string told;   ///< words for people, "set global.rate_hz to 60 (half the time for a refresh)"
};

/// @param price  cost of the cure, empty where none is known
Cure set_to(const std::string& key, const std::string& value, const std::string& price = "");
/// A cure that is no setting with a value, as "press less deep".
Cure advise(const std::string& told);

struct Finding {
  enum class Weight {
    note,     ///< says nothing against the forces
    doubt,    ///< the forces may be off
    failure,  ///< the forces are not those of the scene, and a command ends with exit code 1
  };
  std::string what;           ///< the quantity, its value, its limit
  std::vector<Cure> cures{};  ///< each on its own, the best first
  Weight weight = Weight::doubt;
  std::string where{};            ///< key of the scene that it is about, "object.mesh", "second_tool"
  std::optional<double> value{};  ///< the measured value [SI, a share as such]
  std::optional<double> limit{};  ///< the value from which on it is told

  /// The same with its place and its quantity.
  Finding at(std::string key, std::optional<double> found = {}, std::optional<double> until = {}) &&;
  std::string line() const;  ///< the fact, then its cures with "or" between them
};

/// "this, or that".
std::string alternatives(const std::vector<Cure>& cures);
std::vector<std::string> lines(const std::vector<Finding>& findings);

}  // namespace kt
