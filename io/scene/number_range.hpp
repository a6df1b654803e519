#pragma once
// The range of a number in a scene, as its schema has it: written there alone.
#include <limits>
#include <string>

namespace kt {

struct NumberRange {
  double least = -std::numeric_limits<double>::infinity(), most = std::numeric_limits<double>::infinity();
  bool above = false;  ///< `least` itself is not in it
  bool holds(double value) const { return value <= most && (above ? value > least : value >= least); }
  std::string told() const;  ///< "above 0, at most 100"
};

/// @param key  "contact.mu". Throws InputError: no such key, or none of a number
NumberRange number_range(const std::string& key);

}  // namespace kt
