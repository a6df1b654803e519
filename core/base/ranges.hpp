#pragma once
// Numbers and what they may be, for values that come from code and not from a file, which has its schema.
#include <initializer_list>
#include <limits>
#include <string>

namespace kt {

struct NumberRange {
  std::string key;  ///< as in a scene file, "contact.mu"
  double value = 0;
  double least = 0, most = std::numeric_limits<double>::infinity();
  bool above = false;  ///< `least` itself is not allowed
  bool below = false;  ///< `most` itself is not allowed
};

bool is_within(const NumberRange& number) noexcept;

/// Throws InputError for the first that is not finite or outside: key, value, allowed range.
void require_within(std::initializer_list<NumberRange> numbers);

}  // namespace kt
