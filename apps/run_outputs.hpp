#pragma once
// What a run leaves in its folder: trace.csv, summary.json, view.json, session.json + recording.csv (for replay); of a
// second tool trace_2.csv and so on.
#include <nlohmann/json.hpp>
#include <string>

#include "haptics/session/body_film.hpp"
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

/// Writes every file; the folder is made. Throws InputError when it cannot be written.
/// @param film  goes into view.json; none: the page has no player
void write_run(const std::string& dir, const Session& session, const SessionResult& result,
               const nlohmann::ordered_json& summary, const BodyFilm* film = nullptr);

/// VTU of each snapshot and one PVD, for ParaView.
void write_states(const std::string& dir, const Session& session, const SessionResult& result);

/// From where on a run counts as steady [s]: after the press, or 0.1 s after the first contact.
double steady_from(const Scene& scene, const SessionResult& result);

/// 16 hexadecimal digits.
std::string hash_text(std::uint64_t hash);

}  // namespace kt
