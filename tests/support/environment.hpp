#pragma once
// How long a test runs, from outside: few cases in every build, millions by one command.
#include <cstdlib>

namespace kt {

/// The whole number in the environment variable, or `otherwise` where it is not set.
inline long number_from_environment(const char* variable, long otherwise) {
  const char* text = std::getenv(variable);
  return text ? std::strtol(text, nullptr, 10) : otherwise;
}

}  // namespace kt
