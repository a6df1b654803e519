#pragma once
// session.json of a run: its scene, and what repeats it.
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "haptics/session/session.hpp"

namespace kt {

struct SavedSession {
  Scene scene;
  SessionOptions options;  ///< the run again, in lockstep
  std::string hash;        ///< of the run, as hash_text() writes it
};

/// What a run leaves of itself, its recordings beside it: all that read_session() takes.
nlohmann::ordered_json session_json(const Session& session, const SessionResult& result);

/// The file itself, of a run's folder or of a file. @throws InputError: there is none
std::string session_file(const std::string& file_or_folder);

/// @throws InputError naming the file, the key and what is allowed
SavedSession read_session(const std::string& file);

}  // namespace kt
