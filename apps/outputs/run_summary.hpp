#pragma once
// summary.json of a run: what it computed, how long it took, and what is to be thought of it.
#include <nlohmann/json.hpp>
#include <string>

#include "haptics/session/metrics.hpp"
#include "haptics/session/session.hpp"

namespace kt {

/// summary.json of interface contract: model, force, ticks, times, warnings. Times of the step are CPU time.
nlohmann::ordered_json make_summary(const Session& session, const SessionResult& result);

/// One of its `findings`.
nlohmann::ordered_json finding_json(const Finding& found);

/// 16 hexadecimal digits.
std::string hash_text(std::uint64_t hash);

}  // namespace kt
