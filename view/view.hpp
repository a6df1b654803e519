#pragma once
// `kilotouch view`: a scene that runs, or a session that is played, in the browser.
#include <atomic>

#include "view/live_run.hpp"
#include "view/playback.hpp"
#include "view/server/server.hpp"

namespace kt {

struct ViewOptions {
  ServerOptions server;
  bool by_pointer = true;                  ///< the tool is drawn by the page; else it goes the scene's way
  LiveRun::Save save;                      ///< writes a recording, returns where it lies
  std::function<void()> before_recording;  ///< throws InputError where none can be written
  std::string folder;                      ///< of the scene: files that a page names lie in it
  /// Scenes that a page may open, by the names that it shows.
  std::vector<std::string> scenes;
  std::function<Scene(const std::string& name)> load_scene;
  /// A mesh that was dropped into a page, already examined: a file in a temporary folder.
  std::function<Scene(const std::string& file)> scene_of_mesh;
  /// A closed surface of a mesh file that has holes, in another file of the same folder. @returns that file
  std::function<std::string(const std::string& file)> repair;
  /// What the doctor finds in a mesh file, JSON. In a thread of its own.
  std::function<std::string(const std::string& file)> examine;
  std::function<long long()> count_allocations;  ///< of this thread so far; none: not counted
  LiveRun::NewLink link;                         ///< the body is on another computer; none: it is here
  /// Told when pages can be opened.
  std::function<void(const std::string& url)> ready;
  const std::atomic<bool>* stop = nullptr;
};

/// What can be seen of a body that is touched from another computer.
struct WatchedBody {
  VectorX x;                      ///< [m], (3n)
  std::vector<LocalFrame> tools;  ///< as far as they are known
  TouchStatus status;
};

/// Serves until it is stopped. Throws InputError for a scene or a port that is wrong.
void view_scene(const Scene& scene, const ViewOptions& options);
/// @param look  false: nobody touches the body
void view_watched(const Session& session, const std::function<bool(WatchedBody&)>& look, const ViewOptions& options);
void view_session(const Scene& scene, SceneFiles files, SessionOptions replay, const ViewOptions& options);

}  // namespace kt
