#pragma once
// Recordings of a page: DIR/001, DIR/002, ...
#include <mutex>
#include <optional>
#include <string>

#include "apps/console/stop_signals.hpp"
#include "haptics/session/body_film.hpp"
#include "haptics/session/session.hpp"

namespace kt {

class RecordingFolder {
 public:
  /// @param command  for the summary
  RecordingFolder(std::string dir, std::string command);
  /// Before a recording begins: throws InputError where it could not be written. A stop waits for it from then on.
  void require();
  /// @returns the folder that was written
  std::string save(const Session& session, const SessionResult& result, const BodyFilm& film);

 private:
  std::string dir_, command_;
  std::mutex guard_;
  std::optional<SavingResults> begun_;
};

}  // namespace kt
