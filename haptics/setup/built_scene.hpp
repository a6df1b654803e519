#pragma once
// A scene as it stands before its first tick: everything that takes time to build.
#include <span>
#include <string>
#include <vector>

#include "core/body/surface.hpp"
#include "haptics/contact/friction.hpp"
#include "haptics/setup/scene_files.hpp"
#include "haptics/setup/session_parts.hpp"

namespace kt {

/// Mesh, model, surface, friction, tools and their paths. Throws InputError for what cannot be built.
class BuiltScene {
 public:
  /// @param files  that are read from here and not from the file system
  explicit BuiltScene(const Scene& scene, SceneFiles files = {});
  BuiltScene(const Scene& scene, Mesh body);  ///< the scene with this mesh, in metres, for its own
  BuiltScene(const Scene& scene, std::unique_ptr<DeformableModel> model);  ///< with one's own model for its own
  /// The same body from its start on, along another path: until the time of its last point. Throws InputError, and
  /// keeps its course, for a path that takes no time or leaves a tool's range.
  void follow(std::vector<TimedPoint> path);
  /// The first tool is held by a hand from now on, at the place where its path began: for a target that another thread
  /// moves.
  void hold();
  /// Where the first tool goes, and for how long.
  struct Course {
    ScenePath path;
    ToolPath points;
    double duration = 0;
    bool is_endless = false;
  };
  Course course() const { return {scene_.tool.path, paths_[0], scene_.duration, scene_.is_endless}; }
  /// One that it had before follow(), hold() or last().
  void take(Course course);
  /// It lasted that long [s].
  void last(double seconds) {
    scene_.duration = seconds;
    scene_.is_endless = false;
  }

  const Scene& scene() const { return scene_; }
  const Body& body() const { return body_; }
  /// That its meshes were read from; none of a body that was given.
  const SceneFiles& files() const { return *files_; }
  const TouchOptions& options() const { return options_; }  ///< of the engine
  const DeformableModel& model() const { return body_.model(); }
  const Surface& surface() const { return body_.surface(); }
  double mesh_unit() const { return body_.mesh_unit(); }  ///< of the mesh file [m]; 1 for one that is given in metres
  const ToolShape& tool() const { return tools_[0]; }
  std::span<const ToolShape> tools() const { return tools_; }  ///< 1 or 2
  const SurfaceFriction& friction() const { return friction_; }
  const State& start() const { return body_.start(); }
  const std::vector<TimedPoint>& path() const { return paths_[0].points; }  ///< of the first tool; of a hand its target
  const std::vector<ToolPath>& paths() const { return paths_; }             ///< of each tool
  const std::vector<Finding>& findings() const { return findings_; }        ///< while it was built

 private:
  BuiltScene(const Scene& scene, std::shared_ptr<SceneFiles> files);
  BuiltScene(const Scene& scene, TouchOptions options, Body body, std::shared_ptr<SceneFiles> files);
  Scene scene_;
  std::shared_ptr<const SceneFiles> files_;
  TouchOptions options_;
  Body body_;
  std::vector<ToolShape> tools_;
  SurfaceFriction friction_;
  std::vector<ToolPath> paths_;
  std::vector<Finding> findings_;
};

}  // namespace kt
