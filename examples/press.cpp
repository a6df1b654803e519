#include <cstdio>
#include <kilotouch/kilotouch.hpp>

int main() {
  kt::BodyOptions made;
  made.object.mesh = "meshes/sphere.off";  // a ball of 6 cm, glued at its lowest twentieth
  made.object.layers = kt::SceneLayers{.count = 2, .thickness = 0.005};  // m; without: filled with tetrahedra
  made.object.model.young = 8e3;                                         // Pa
  const kt::Body body(made);

  kt::TouchOptions options;
  options.tools[0].shape = {kt::ToolShape::Kind::sphere, 0.004};  // m
  options.contact.mu_static = options.contact.mu_kinetic = 0.3;
  kt::Touch touch(body, options);

  const double top = kt::bounds(body.model().mesh()).max.z() + 0.004;
  for (int i = 1; i <= 500; ++i) {  // down by 3 mm, then along at 5 cm/s
    const double t = 1e-3 * i, down = std::min(1.0, t / 0.2), along = 0.05 * std::max(0.0, t - 0.2);
    const kt::LocalFrame& f = touch.tick(kt::Pose{{along, 0, top - 0.003 * down}});
    if (i % 100 == 0)
      std::printf("%.1f s: normal %.4f N, friction %.4f N, %s\n", f.t, f.f_n, f.f_t, kt::name_of(f.mode));
  }
}
