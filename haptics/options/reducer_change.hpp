#pragma once
#include <string>

namespace kt {

/// "auto" went over to another candidate, at the end of the refresh at this tick.
struct ReducerChange {
  int tick = 0;
  std::string from, to;    ///< names of candidates
  std::string why;         ///< in words
  double error = 0;        ///< of the new one: certified, worst of 0-500 Hz; NaN: not known
  double force_error = 0;  ///< to expect of it
  bool operator==(const ReducerChange&) const = default;
};

}  // namespace kt
