#pragma once
// What a run leaves in its folder: trace.csv, summary.json, view.json, session.json, recording.csv and the meshes in
// session/ (for replay); of a second tool trace_2.csv and so on.
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "haptics/session/body_film.hpp"
#include "haptics/session/session.hpp"

namespace kt {

/// Files that a run may leave in its folder.
std::vector<std::string> run_output_names();

/// Writes every file, or none: the folder is made. Throws InputError when it cannot be written.
/// @param film  goes into view.json; none: the page has no player
void write_run(const std::string& dir, const Session& session, const SessionResult& result,
               const nlohmann::ordered_json& summary, const BodyFilm* film = nullptr);

/// VTU of each snapshot and one PVD, for ParaView.
void write_states(const std::string& dir, const Session& session, const SessionResult& result);

}  // namespace kt
