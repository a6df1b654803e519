#pragma once
// A run's summary in words.
#include <nlohmann/json.hpp>

namespace kt {

/// The first screen: the force, whether it is real time, whether it is to be trusted, each with what cures it.
void print_summary(const nlohmann::ordered_json& summary);

/// Every figure that has a line.
void print_details(const nlohmann::ordered_json& summary);

}  // namespace kt
