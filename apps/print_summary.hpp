#pragma once
// A run's summary in words.
#include <nlohmann/json.hpp>

namespace kt {

/// A few lines on standard output: what happened.
void print_summary(const nlohmann::ordered_json& summary);

}  // namespace kt
