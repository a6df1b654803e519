#pragma once
// What was found out about a scene or a run: for whoever reads its forces.
#include <string>
#include <vector>

namespace kt {

/// A way out of what was found.
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

  std::string line() const;  ///< "what; this cure, or that one"
};

/// "this, or that".
std::string alternatives(const std::vector<Cure>& cures);
std::vector<std::string> lines(const std::vector<Finding>& findings);

/// Three digits: "0.0376".
std::string short_number(double value);
/// Of a share: "3.76 %", "243 %".
std::string in_percent(double share);

}  // namespace kt
