// Tools dragged over whole closed surfaces for 10^5 ticks: contacts lost, impacts with what is held already,
// penetration, and how much normal and force jump where the contact crosses an edge.
//   build/release/bench/sliding_table [--ticks N] [--mu MU]... [--csv FILE] [--jumps FILE] [MESH...]
// MESH: closed surface meshes in any unit, brought to 0.1 m; besides those of meshes/. --jumps: every crossing of an
// edge.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "bench/sliding.hpp"
#include "core/base/error.hpp"

namespace kt {
namespace {

struct Options {
  int ticks = 100000;
  std::vector<double> mu;
  std::string csv, jumps;
  std::vector<std::string> meshes;
};

struct NamedTool {
  const char* name;
  double radius, depth;  // of the mean edge
};
// A small sphere lies on one face; a large one on several.
constexpr NamedTool kTools[] = {{"point", 0, 0.15}, {"small sphere", 0.5, 0.05}, {"large sphere", 4, 0.08}};
constexpr double kSpeed = 6;  // mean edges a second: a tick goes 0.6 % of an edge

Mesh load_scaled(const std::string& path) {
  Mesh mesh = load_mesh(path);
  const Bounds box = bounds(mesh);
  mesh.x *= 0.1 / box.size().maxCoeff();
  return mesh;
}

/// Half an edge's angle lies between the faces there and the blended normal, along which a point is pressed on it: with
/// a friction angle of that size the edge sticks to the tool and is carried along for ever. Such bodies get less
/// friction.
double friction(const SlidingBody& body, const NamedTool& tool, double mu) {
  double sharpest = 0;  // [deg]
  for (int t = 0; t < static_cast<int>(body.patch.triangles.size()); ++t)
    for (int across : body.patch.topology.across[t]) sharpest = std::max(sharpest, dihedral_angle(body, t, across));
  const double angle = std::atan(mu) * 180 / std::acos(-1.0);
  return tool.radius == 0 && angle > 0.4 * sharpest && sharpest > 60 ? std::min(mu, 0.5) : mu;
}

void run(const std::string& path, double wanted_mu, const Options& options, std::ofstream& csv, std::ofstream& jumps) {
  const SlidingBody body(load_scaled(path));
  const std::string name = std::filesystem::path(path).filename().string();
  for (const NamedTool& t : kTools) {
    const double mu = friction(body, t, wanted_mu);
    const ToolShape tool{t.radius > 0 ? ToolShape::Kind::sphere : ToolShape::Kind::point, t.radius * body.edge};
    const SlidingReport r =
        slide(body, tool, mu, t.depth * body.edge, kSpeed * body.edge, options.ticks, [](const LocalFrame&) {});
    std::printf("%-28s %-12s %4.1f | %6d %5d %5d %5d %5d | %5d %8.1e %8.1e | %7.3f %5.2f | %6zu %8.1e\n", name.c_str(),
                t.name, mu, r.ticks, r.lost, r.events, r.double_hits, r.exhausted, r.deep, r.penetration, r.hover,
                r.mean_force, r.mean_contacts, r.crossings.size(), r.steady_jump);
    std::fflush(stdout);
    if (csv.is_open()) {
      csv << name << ',' << t.name << ',' << mu << ',' << r.ticks << ',' << r.lost << ',' << r.events << ','
          << r.double_hits << ',' << r.exhausted << ',' << r.deep << ',' << r.penetration << ',' << r.hover << ','
          << r.mean_force << ',' << r.mean_contacts << ',' << r.crossings.size() << ',' << r.steady_jump << '\n';
    }
    if (jumps.is_open())
      for (const EdgeCrossing& c : r.crossings)
        jumps << name << ',' << t.name << ',' << mu << ',' << c.dihedral << ',' << c.normal_jump << ',' << c.force_jump
              << '\n';
  }
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  kt::Options options;
  CLI::App app;
  app.add_option("--ticks", options.ticks)->check(CLI::PositiveNumber);
  app.add_option("--mu", options.mu)->allow_extra_args(false);
  app.add_option("--csv", options.csv);
  app.add_option("--jumps", options.jumps, "every crossing of an edge");
  app.add_option("meshes", options.meshes, "besides those of meshes/");
  CLI11_PARSE(app, argc, argv);
  std::ofstream csv, jumps;
  if (!options.csv.empty()) csv.open(options.csv);
  if (!options.jumps.empty()) jumps.open(options.jumps);
  csv << "mesh,tool,mu,ticks,lost,events,double_hits,exhausted,deep,penetration,hover,mean_force,mean_contacts,"
         "crossings,"
         "steady_jump\n";
  jumps << "mesh,tool,mu,dihedral,normal_jump,force_jump\n";
  if (options.mu.empty()) options.mu = {0, 0.3, 1};
  if (options.meshes.empty())
    for (const char* name : {"sphere.off", "torus.off", "organ.off", "block.msh", "genus5.off"})
      options.meshes.push_back(std::string(KT_SOURCE_DIR "/meshes/") + name);
  std::printf("%-28s %-12s %4s | %6s %5s %5s %5s %5s | %5s %8s %8s | %7s %5s | %6s %8s\n", "mesh", "tool", "mu",
              "ticks", "lost", "hits", "twice", "over", "deep", "depth", "hover", "force", "held", "edges", "steady");
  try {
    for (double mu : options.mu)
      for (const std::string& path : options.meshes) kt::run(path, mu, options, csv, jumps);
  } catch (const kt::InputError& e) {
    return std::fprintf(stderr, "%s\n", e.what()), 2;
  }
}
