#pragma once
// A small scene for session tests: a block, a tool that presses and drags. Runs in every build.
#include "io/scene/scene.hpp"

namespace kt {

inline Scene small_scene(const std::string& shape = "sphere") {
  Scene scene;
  scene.title = "test";
  scene.duration = 0.3;
  scene.object.mesh = KT_SOURCE_DIR "/meshes/block.msh";
  scene.tool.shape = shape;
  scene.tool.path.press_drag = PressDrag{.at = std::array<double, 2>{0.03, 0.026},
                                         .depth = 0.002,
                                         .press_time = 0.1,
                                         .direction = {1, 0.2, 0},
                                         .speed = 0.05};
  scene.contact.mu_static = 0.5;
  scene.contact.mu_kinetic = 0.4;
  scene.collision.backend = "brute_force";
  scene.local.reducer = "condensed";  // the default, auto, certifies eight of them first
  scene.local.refine = "off";         // what is tested is the method, against bodies of the same cells
  return scene;
}

}  // namespace kt
