// Presses a sphere into a soft ball, drags it to the side, and prints the force every 50 ms.
//   press meshes/sphere.off
#include <cstdio>

#include "haptics/session.hpp"

int main(int argc, char** argv) try {
  kt::Scene scene;
  scene.duration = 0.5;  // s
  scene.object.mesh = argc > 1 ? argv[1] : "meshes/sphere.off";
  scene.object.layers = kt::SceneLayers{.count = 2, .thickness = 0.005};  // inner masses: no tetrahedralizer needed
  scene.object.model.young = 8e3;                                         // Pa
  scene.contact.mu_static = scene.contact.mu_kinetic = 0.3;
  scene.collision.backend = "brute_force";  // in every build

  kt::Session session(scene);
  for (const kt::LocalFrame& f : session.run().frames)
    if (f.contacts > 0 && static_cast<int>(f.t * 1000 + 0.5) % 50 == 0)
      std::printf("t %.2f s: normal %.4f N, friction %.4f N, %s\n", f.t, f.f_n, f.f_t, kt::name_of(f.mode));
} catch (const std::exception& e) {
  std::fprintf(stderr, "press: %s\n", e.what());
  return 1;
}
