#pragma once
// session.json of a run: its scene, and what repeats it.
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "haptics/session/session.hpp"

namespace kt {

struct SavedSession {
  Scene scene;
  SceneFiles files;        ///< that the scene names, as they were
  SessionOptions options;  ///< the run again, in lockstep
  std::string hash;        ///< of the run, as hash_text() writes it
};

/// A file that a session holds: the mesh of the body or of a tool, or one half of a TetGen pair.
struct HeldFile {
  std::string key;      ///< of the scene: "object.mesh"
  std::string name;     ///< in kHeldFiles: "body.off"
  std::string from;     ///< where the run read it
  std::string content;  ///< as it was then
};

constexpr const char* kHeldFiles = "session";  ///< folder beside session.json

/// The scene in JSON, with paths that hold from every folder.
std::string scene_text(const Scene& scene);

std::vector<HeldFile> held_files(const BuiltScene& built);

/// What a run leaves of itself, its recordings and held_files() beside it: all that read_session() takes.
nlohmann::ordered_json session_json(const Session& session, const SessionResult& result);

/// The file itself, of a run's folder or of a file. @throws InputError: there is none
std::string session_file(const std::string& file_or_folder);

/// @throws InputError naming the file, the key and what is allowed; or the mesh that is gone or not that of the run
SavedSession read_session(const std::string& file);

}  // namespace kt
