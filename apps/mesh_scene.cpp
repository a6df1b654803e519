#include "apps/mesh_scene.hpp"

#include <filesystem>

namespace kt {

Scene scene_of_mesh(const std::string& mesh, const std::vector<std::string>& set) {
  // Settings are applied to a scene that already names the mesh, so that --set can change everything.
  Scene base = default_scene();
  base.title = "drag over " + std::filesystem::path(mesh).filename().string();
  base.duration = 1.2;
  base.object.mesh = mesh;
  base.object.size = 0.1;
  base.object.repair = true;
  base.object.fixed.below = FixedBelow{"z", 0.2};
  base.tool.radius = 0.004;
  base.tool.path.press_drag->depth = 0.003;
  base.tool.path.press_drag->speed = 0.04;
  base.tool.path.press_drag->ease = "minimum_jerk";
  return parse_scene(to_json(base), set, "drag " + mesh);
}

}  // namespace kt
