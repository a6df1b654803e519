#pragma once
// What was found out about a scene or a run: for whoever reads its forces.
#include <optional>
#include <string>
#include <vector>

namespace kt {

/// A setting or an action that ends what was found.
struct Cure {
  std::string key;    ///< the setting of the scene, "global.rate_hz"; empty: no setting
  std::string value;  ///< as `--set key=value` takes it; empty: no one value
  std::string told;   ///< for people: "set global.rate_hz to 60 (half the time for a refresh)"
};

/// @param price  what the cure costs; empty: nothing that is known
Cure set_to(const std::string& key, const std::string& value, const std::string& price = "");
/// A cure that is no setting with a value: "press less deep".
Cure advise(const std::string& told);

struct Finding {
  enum class Weight {
    note,     ///< says nothing against the forces
    doubt,    ///< the forces may be off
    failure,  ///< the forces are not those of the scene: a command ends with exit code 1
  };
  std::string what;           ///< the quantity, its value, its limit
  std::vector<Cure> cures{};  ///< each on its own, the best first
  Weight weight = Weight::doubt;
  std::string where{};            ///< key of the scene that it is about: "object.mesh", "second_tool"
  std::optional<double> value{};  ///< that was found [SI; a share as such]
  std::optional<double> limit{};  ///< from which on it is told

  /// The same with its place and its quantity.
  Finding at(std::string key, std::optional<double> found = {}, std::optional<double> until = {}) &&;
  std::string line() const;  ///< "what; this cure, or that one"
};

/// "this, or that".
std::string alternatives(const std::vector<Cure>& cures);
std::vector<std::string> lines(const std::vector<Finding>& findings);

}  // namespace kt
