#include <cstdio>

#include "haptics/session.hpp"

int main() {
  kt::Scene scene;                          // press, then drag: the default tool path
  scene.object.mesh = "meshes/sphere.off";  // a ball of 6 cm, glued at its lowest twentieth
  scene.object.layers = kt::SceneLayers{.count = 2, .thickness = 0.005};  // m; without: filled with tetrahedra
  scene.object.model.young = 8e3;                                         // Pa
  scene.contact.mu_static = scene.contact.mu_kinetic = 0.3;
  scene.collision.backend = "brute_force";  // is in every build

  kt::Session session(scene);
  const kt::SessionResult result = session.run();
  for (std::size_t i = 99; i < result.tools[0].frames.size(); i += 100) {
    const kt::LocalFrame& f = result.tools[0].frames[i];
    std::printf("%.1f s: normal %.4f N, friction %.4f N, %s\n", f.t, f.f_n, f.f_t, kt::name_of(f.mode));
  }
}
