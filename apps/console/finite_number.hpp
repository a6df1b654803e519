#pragma once
// Options that are numbers: CLI11's own ranges take nan, which is in all of them.
#include <CLI/CLI.hpp>
#include <string>

#include "core/base/error.hpp"

namespace kt {

/// A number from `low` to `high`.
inline CLI::Validator number_within(double low, double high) {
  const std::string range = text("FLOAT in [", low, " - ", high, "]");
  return {[=](std::string& word) {
            double value = 0;
            if (CLI::detail::lexical_cast(word, value) && value >= low && value <= high) return std::string();
            return text("\"", word, "\" is not a number from ", low, " to ", high);
          },
          range};
}

/// A number above 0, and below what no clock and no memory has.
inline CLI::Validator positive_number() {
  constexpr double kMost = 1e9;
  return {[=](std::string& word) {
            double value = 0;
            if (CLI::detail::lexical_cast(word, value) && value > 0 && value <= kMost) return std::string();
            return text("\"", word, "\" is not a number above 0, at most ", kMost);
          },
          "POSITIVE"};
}

}  // namespace kt
