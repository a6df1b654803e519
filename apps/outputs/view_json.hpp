#pragma once
// view.json: what pictures of a run need, and its player.
#include <nlohmann/json.hpp>

#include "haptics/session/body_film.hpp"
#include "haptics/session/session.hpp"

namespace kt {

/// Surface nodes only, renumbered: tools, snapshots, rest positions, triangles, the tools' paths.
/// @param film  may be null. Its positions: 16 bits each in the box of all of them, x = low + step * value,
///              little-endian, three a node, one text of base64 a frame
nlohmann::ordered_json view_json(const Session& session, const SessionResult& result, const BodyFilm* film);

}  // namespace kt
