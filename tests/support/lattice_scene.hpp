#pragma once
// A block, or a scan, as a body of a lattice.
#include "haptics/session/session.hpp"

namespace kt {

inline Mesh surface_of(Mesh mesh) {
  mesh.tetrahedra.clear();
  return mesh;
}

inline Scene scene_of_lattice() {
  Scene s = default_scene();
  s.object.mesh = "block";
  s.object.body = "lattice";
  s.object.model.type = "fem";
  s.object.fixed.below = FixedBelow{"z", 1e-6};
  s.tool.radius = 0.008;
  s.duration = 0.3;
  s.local.refine = "off";
  s.collision.backend = "brute_force";
  return s;
}

}  // namespace kt
