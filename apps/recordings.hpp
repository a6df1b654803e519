#pragma once
// Recordings of a page: DIR/001, DIR/002, ...
#include <string>

#include "haptics/session/body_film.hpp"
#include "haptics/session/session.hpp"

namespace kt {

/// @returns the folder that was written
std::string save_recording(const std::string& dir, const std::string& command, const Session& session,
                           const SessionResult& result, const BodyFilm& film);

}  // namespace kt
