#pragma once
// What a run says of a device that somebody held.
#include <nlohmann/json.hpp>

#include "haptics/session/session.hpp"

namespace kt {

/// Of a tool with a device; times in milliseconds.
nlohmann::ordered_json device_json(const ToolRun& tool);

/// "Inverse3 049D: at most 3 N; pose age 0.27 ms, p99 0.6; ..."
std::string device_line(const nlohmann::ordered_json& device);

}  // namespace kt
