// Bodies of a lattice from the surfaces of files: time to make them, nodes, refresh, refreshes a second in two threads,
// and the force of frictionless presses at three places and depths, at rest with the body, over that of a mesh of
// tetrahedra with refined cells under the tool.
//   lattice_table [--nodes N] [--truth EDGE] [--depths D,D,...] [--raw] [--triangles N] [--seconds S] FILE...
// Each file scaled to 12 cm, clamped at its lowest twentieth, 10 kPa, nu = 0.3; a ball of 6 mm. The mesh is TetGen's,
// of a surface with edges of at most EDGE [m] (0.005; 0: none); without it, and where TetGen refuses the surface,
// forces are printed [mN]. --triangles cuts the file's into at least so many, roughened by a thousandth of the size.
// --raw: the cubes as they are, too. --seconds: of the run in two threads (0: none).
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <random>
#include <sstream>

#include "core/base/percentile.hpp"
#include "haptics/session/session.hpp"
#include "io/mesh/mesh_io.hpp"
#include "io/solid/lattice.hpp"
#include "io/surface/refine_surface.hpp"

namespace kt {
namespace {

struct Options {
  int nodes = 0, triangles = 0;
  double truth = 0.005;  // [m]; 0: none
  std::vector<double> depths{0.0005, 0.0015, 0.003};
  bool raw = false;
  double seconds = 0;
};

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

Scene scene_of(const std::string& file) {
  Scene s = default_scene();
  s.object.mesh = file;
  s.object.model.type = std::string("fem");
  s.object.model.material = std::string("linear");
  s.object.fixed.below = FixedBelow{};
  s.tool.radius = 0.006;
  s.duration = 2;  // a tall body swings away from the press at first
  s.contact.mu_static = s.contact.mu_kinetic = 0;
  s.contact.surface = std::string("flat");
  s.local.reducer = std::string("condensed");
  s.local.refine = "follow";
  s.collision.backend = std::string("embree");
  return s;
}

Mesh surface_of(const std::string& file, int triangles) {
  Mesh mesh = load_mesh(file);
  if (!mesh.tetrahedra.empty()) mesh.triangles = boundary_triangles(mesh.tetrahedra);
  mesh.tetrahedra.clear();
  mesh.x *= 0.12 / bounds(mesh).size().maxCoeff();
  std::mt19937_64 random(1);
  while (static_cast<int>(mesh.triangles.size()) < triangles) {
    const int before = mesh.num_nodes();
    double longest = 0;
    for (const Triangle& t : mesh.triangles)
      for (std::size_t c = 0; c < 3; ++c)
        longest = std::max(longest, (node(mesh.x, t[c]) - node(mesh.x, t[(c + 1) % 3])).norm());
    mesh = refine_surface(std::move(mesh), {.radius = std::numeric_limits<double>::infinity(), .edge = 0.7 * longest},
                          10'000'000);
    const VectorX normals = node_normals(mesh.x, mesh.triangles);
    for (int i = before; i < mesh.num_nodes(); ++i)
      node(mesh.x, i) += 1e-3 * 0.12 * std::uniform_real_distribution<>(-1, 1)(random) * std::min(1.0, longest / 0.01) *
                         node(normals, i);
  }
  return mesh;
}

struct Pressed {
  double force = 0, refresh_ms = 0, longest_ms = 0, tick_us = 0, made_s = 0, rate_hz = 0;
  int nodes = 0;
};

Pressed press(Scene s, const Mesh& surface, const std::array<double, 2>& at, double depth) {
  s.tool.path.press_drag = PressDrag{.at = at, .depth = depth, .press_time = 0.3, .speed = 0};
  const auto begin = std::chrono::steady_clock::now();
  Session session(s, surface);
  Pressed out;
  out.made_s = seconds_since(begin);
  out.nodes = session.model().mesh().num_own_nodes();
  const SessionResult r = session.run();
  const std::vector<double> refreshes(r.refresh.cpu_ms.begin() + 1, r.refresh.cpu_ms.end());
  out.refresh_ms = percentile(refreshes, 0.5);
  out.longest_ms = refreshes.empty() ? 0 : std::ranges::max(refreshes);
  out.tick_us = percentile(r.step_us, 0.5);
  out.rate_hz = static_cast<double>(refreshes.size()) / s.duration;
  out.force = r.tools[0].frames.back().f_n;
  return out;
}

Mesh tetrahedra_of(const Mesh& surface, const std::string& file, double edge) {
  SceneObject object;
  object.mesh = file;
  object.tetrahedralize = SceneTetrahedralize{};
  object.tetrahedralize->max_edge = edge;
  return filled(surface, object);
}

void print_row(const std::string& file, const Options& options) {
  const Mesh surface = surface_of(file, options.triangles);
  Scene lattice = scene_of(file);
  lattice.object.body = std::string("lattice");
  if (options.nodes > 0) lattice.object.lattice = SceneLattice{{}, options.nodes};
  auto begin = std::chrono::steady_clock::now();
  LatticeReport report;
  make_lattice(surface, {.nodes = options.nodes > 0 ? options.nodes : 600}, &report);
  const double lattice_s = seconds_since(begin);
  std::optional<Mesh> truth;
  if (options.truth > 0) try {
      truth = tetrahedra_of(surface, file, options.truth);
    } catch (const std::exception& e) {
      std::fprintf(stderr, "%s: %s\n", file.c_str(), e.what());
    }
  const Bounds box = bounds(surface);
  std::string forces;
  Pressed of;
  double longest_ms = 0;
  std::vector<double> refresh, ticks;
  for (const double depth : options.depths) {
    forces += " |";
    for (const auto& [x, y] : {std::pair(0.5, 0.5), {0.35, 0.45}, {0.6, 0.6}}) {
      const std::array<double, 2> at{box.min.x() + x * box.size().x(), box.min.y() + y * box.size().y()};
      const double unit = truth ? press(scene_of(file), *truth, at, depth).force : 1e-3;
      const auto add = [&](double force) {
        char shown[64];
        std::snprintf(shown, sizeof shown, truth ? " %.2f" : " %.1f", force / unit);
        forces += shown;
      };
      of = press(lattice, surface, at, depth);
      add(of.force);
      refresh.push_back(of.refresh_ms);
      ticks.push_back(of.tick_us);
      longest_ms = std::max(longest_ms, of.longest_ms);
      if (!options.raw) continue;
      Scene raw = lattice;
      raw.local.refine = "off";
      forces += " (";
      add(press(raw, surface, at, depth).force);
      forces += ")";
    }
  }
  std::string held = "-";
  if (options.seconds > 0) {
    Scene threads = lattice;
    threads.link.type = "thread";
    threads.duration = options.seconds;
    const Pressed run = press(threads, surface, {box.centre().x(), box.centre().y()}, 0.0015);
    held = std::to_string(static_cast<int>(std::lround(run.rate_hz)));
  }
  const std::size_t name = file.find_last_of('/') + 1;
  std::printf("| %s | %zu | %.2f | %.2f | %d | %d | %.0f | %.0f | %.0f | %s%s%s |\n", file.c_str() + name,
              surface.triangles.size(), lattice_s, of.made_s, of.nodes, report.parted_cubes, percentile(refresh, 0.5),
              longest_ms, percentile(ticks, 0.5), held.c_str(), forces.c_str(), truth ? "" : " mN");
  std::fflush(stdout);
}

std::vector<double> numbers_in(const char* list) {
  std::vector<double> out;
  std::istringstream in(list);
  for (std::string one; std::getline(in, one, ',');) out.push_back(std::atof(one.c_str()));
  return out;
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  kt::Options options;
  std::puts(
      "| surface | triangles | lattice s | made s | nodes | parted | refresh ms | longest | tick us | Hz held | force "
      "/ "
      "mesh, of each depth |");
  std::puts("|---|---|---|---|---|---|---|---|---|---|---|");
  for (int i = 1; i < argc; ++i) {
    const auto is = [&](const char* name) { return std::strcmp(argv[i], name) == 0 && i + 1 < argc; };
    if (std::strcmp(argv[i], "--raw") == 0)
      options.raw = true;
    else if (is("--nodes"))
      options.nodes = std::atoi(argv[++i]);
    else if (is("--triangles"))
      options.triangles = std::atoi(argv[++i]);
    else if (is("--seconds"))
      options.seconds = std::atof(argv[++i]);
    else if (is("--depths"))
      options.depths = kt::numbers_in(argv[++i]);
    else if (is("--truth"))
      options.truth = std::atof(argv[++i]);
    else
      try {
        kt::print_row(argv[i], options);
      } catch (const std::exception& e) {
        std::printf("| %s | %s |\n", argv[i], e.what());
        std::fflush(stdout);
      }
  }
}
