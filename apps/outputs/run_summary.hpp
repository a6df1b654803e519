#pragma once
// summary.json of a run: what it computed, how long it took, and what is to be thought of it.
#include <nlohmann/json.hpp>
#include <string>

#include "haptics/session/session.hpp"
#include "haptics/study/metrics.hpp"
#include "haptics/study/reference.hpp"

namespace kt {

/// summary.json of interface contract: model, force, ticks, times, warnings. Times of the step are CPU time.
nlohmann::ordered_json make_summary(const Session& session, const SessionResult& result);

/// The summary's `reference`: how far the run's forces are from it, and its warnings.
void add_reference(nlohmann::ordered_json& summary, const SessionResult& result, const Reference& reference);

/// The summary's `truth`: the same against forces of another body, law or mesh along the same tool path, and how far
/// the tool's work is off.
void add_truth(nlohmann::ordered_json& summary, const SessionResult& result, const Reference& truth);

/// 16 hexadecimal digits.
std::string hash_text(std::uint64_t hash);

}  // namespace kt
