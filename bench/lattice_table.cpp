// Bodies of a lattice from the surfaces of files: time to make them, nodes, refresh, and the force of frictionless
// presses at three places, at rest with the body, over that of a mesh of tetrahedra with refined cells under the tool.
//   lattice_table [--nodes N] [--truth EDGE] [--fineness F] FILE...
// Each file scaled to 12 cm, clamped at its lowest twentieth, 10 kPa, nu = 0.3; a ball of 6 mm, 2 mm deep. The mesh is
// TetGen's, of a surface with edges of at most EDGE [m] (0.005); without it, and where TetGen refuses the surface, the
// forces themselves are printed [mN].
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "haptics/session/session.hpp"
#include "io/mesh/mesh_io.hpp"

namespace kt {
namespace {

struct Options {
  int nodes = 0;
  double truth = 0.005;  // [m]; 0: none
  double fineness = 1.4;
};

Scene scene_of(const std::string& file) {
  Scene s = default_scene();
  s.object.mesh = file;
  s.object.size = 0.12;
  s.object.model.type = std::string("fem");
  s.object.model.material = std::string("linear");
  s.tool.radius = 0.006;
  s.duration = 2;  // a tall body swings away from the press at first
  s.contact.mu_static = s.contact.mu_kinetic = 0;
  s.contact.surface = std::string("flat");
  s.local.reducer = std::string("condensed");
  s.collision.backend = std::string("embree");
  return s;
}

struct Pressed {
  double force = 0, refresh_ms = 0, tick_us = 0, made_s = 0, depth = 0;
  int nodes = 0, triangles = 0;
};

Pressed press(Scene s, const std::array<double, 2>& at, const char* refine) {
  s.local.refine = refine;
  s.tool.path.press_drag = PressDrag{.at = at, .depth = 0.002, .press_time = 0.3, .speed = 0};
  const auto begin = std::chrono::steady_clock::now();
  Session session(s);
  Pressed out;
  out.made_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const Mesh& mesh = session.model().mesh();
  out.nodes = mesh.num_own_nodes();
  out.triangles = static_cast<int>(mesh.triangles.size());
  const SessionResult r = session.run();
  const auto median = [](std::vector<double> values) {
    if (values.empty()) return 0.0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::ranges::nth_element(values, middle);
    return *middle;
  };
  out.refresh_ms = median(std::vector<double>(r.refresh.cpu_ms.begin() + 1, r.refresh.cpu_ms.end()));
  out.tick_us = median(std::vector<double>(r.step_us.begin(), r.step_us.end()));
  out.force = r.tools[0].frames.back().f_n;
  for (const double p : r.tools[0].penetration) out.depth = std::max(out.depth, p);
  return out;
}

void print_row(const std::string& file, const Options& options) {
  Scene lattice = scene_of(file);
  lattice.object.body = std::string("lattice");
  lattice.local.fineness = options.fineness;
  if (options.nodes > 0) lattice.object.lattice = SceneLattice{{}, options.nodes};
  const Mesh surface = load_mesh(file);
  const Bounds box = bounds(surface);
  const double unit = 0.12 / box.size().maxCoeff();
  Pressed of[2];
  std::string forces[2];
  bool is_judged = options.truth > 0;
  for (const auto& [x, y] : {std::pair(0.5, 0.5), {0.35, 0.45}, {0.6, 0.6}}) {
    const std::array<double, 2> at{unit * (box.min.x() + x * box.size().x()),
                                   unit * (box.min.y() + y * box.size().y())};
    double truth = 1e-3;
    if (is_judged) try {
        Scene mesh = scene_of(file);
        mesh.object.tetrahedralize = SceneTetrahedralize{};
        mesh.object.tetrahedralize->max_edge = options.truth;
        truth = press(mesh, at, "follow").force;
      } catch (const std::exception& e) {
        std::fprintf(stderr, "%s: %s\n", file.c_str(), e.what());
        is_judged = false;
      }
    for (const int i : {0, 1}) {
      of[i] = press(lattice, at, i == 0 ? "off" : "follow");
      char shown[64];
      std::snprintf(shown, sizeof shown, is_judged ? " %.2f" : " %.1f", of[i].force / truth);
      forces[i] += shown;
    }
  }
  const std::size_t name = file.find_last_of('/') + 1;
  std::printf("| %s | %zu | %.2f | %d | %.1f | %.1f | %.0f | %.0f |%s |%s | %.2f |%s\n", file.c_str() + name,
              surface.triangles.size(), of[0].made_s, of[0].nodes, of[0].refresh_ms, of[1].refresh_ms, of[0].tick_us,
              of[1].tick_us, forces[0].c_str(), forces[1].c_str(), 1e3 * std::max(of[0].depth, of[1].depth),
              is_judged ? "" : " mN");
  std::fflush(stdout);
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  kt::Options options;
  std::puts(
      "| surface | triangles | made s | nodes | refresh ms | refined | tick us | refined | force / mesh | refined | "
      "deepest mm |");
  std::puts("|---|---|---|---|---|---|---|---|---|---|---|");
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--nodes") == 0 && i + 1 < argc)
      options.nodes = std::atoi(argv[++i]);
    else if (std::strcmp(argv[i], "--fineness") == 0 && i + 1 < argc)
      options.fineness = std::atof(argv[++i]);
    else if (std::strcmp(argv[i], "--truth") == 0 && i + 1 < argc)
      options.truth = std::atof(argv[++i]);
    else
      try {
        kt::print_row(argv[i], options);
      } catch (const std::exception& e) {
        std::printf("| %s | %s |\n", argv[i], e.what());
      }
  }
}
