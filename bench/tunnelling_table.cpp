// Tools shot at meshes, 0.1 to 50 m/s in ticks of 1 ms, aimed at faces, edges and vertices of resting, moving and
// deforming surfaces: does the engine report every impact in time? The truth is computed in 113 bits.
//   build/release/bench/tunnelling_table [--shots N] [--seed N] [--csv FILE] [mesh or folder]...
// Besides the given ones: meshes/, meshes/broken/ and two sheets of one layer. Exit code 1: something leaked.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <map>
#include <stdexcept>

#include "io/files/output_file.hpp"
#include "io/mesh/mesh_io.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/shooting.hpp"

namespace kt {
namespace {

namespace fs = std::filesystem;

constexpr int kSalvo = 200;    // shots at one motion of the surface
constexpr double kSize = 0.1;  // [m], largest side of every mesh

struct Options {
  long shots = 1000000;
  unsigned seed = 1;
  std::string csv;
  std::vector<std::string> meshes;
};

struct TargetMesh {
  std::string name;
  Mesh mesh;
};

/// One layer of triangles over [0, kSize]^2 with three waves of `height` each way.
Mesh one_layer(double height) {
  Mesh mesh = sheet(30, 30, kSize / 30);
  for (int i = 0; i < mesh.num_nodes(); ++i) {
    const Vec3 x = node(mesh.x, i);
    node(mesh.x, i).z() = height * std::sin(60 * std::acos(-1.0) * x.x()) * std::cos(60 * std::acos(-1.0) * x.y());
  }
  return mesh;
}

std::vector<std::string> mesh_files(const std::vector<std::string>& places) {
  std::vector<std::string> out;
  for (const std::string& place : places) {
    if (!fs::is_directory(place)) {
      out.push_back(place);
      continue;
    }
    std::vector<std::string> inside;
    const auto known = readable_mesh_extensions();
    for (const auto& entry : fs::directory_iterator(place))
      if (std::find(known.begin(), known.end(), mesh_extension(entry.path().string())) != known.end())
        inside.push_back(entry.path().string());
    std::sort(inside.begin(), inside.end());
    out.insert(out.end(), inside.begin(), inside.end());
  }
  return out;
}

/// What can be loaded, with kSize as its largest side; the rest is listed with the reader's words.
std::vector<TargetMesh> load_targets(const std::vector<std::string>& files) {
  std::vector<TargetMesh> out{{"(flat sheet)", one_layer(0)}, {"(wavy sheet)", one_layer(0.003)}};
  for (const std::string& file : files) {
    const std::string name = fs::path(file).filename().string();
    try {
      Mesh mesh = load_mesh(file);
      const double size = bounds(mesh).size().maxCoeff();
      if (mesh.triangles.empty() || !(size > 0)) throw std::runtime_error("no triangles, or all in one place");
      mesh.x *= kSize / size;
      out.push_back({name, std::move(mesh)});
    } catch (const std::exception& error) {
      const std::string text = error.what();
      const auto at = text.find(name);
      std::printf("not loaded: %s\n", at == std::string::npos ? (name + ": " + text).c_str() : text.c_str() + at);
    }
  }
  return out;
}

struct Row {
  ShotCount count;
  double seconds = 0;
};
using Rows = std::map<std::string, Row>;

const char* name_of(SurfaceMotion m) {
  return m == SurfaceMotion::still   ? "surface still"
         : m == SurfaceMotion::rigid ? "surface moving"
                                     : "surface deforming";
}
const char* name_of(ShotTarget t) {
  return t == ShotTarget::face ? "at faces" : t == ShotTarget::edge ? "at edges" : "at vertices";
}

/// The rows of the summary that a shot counts in.
std::vector<std::string> kinds_of(const Shot& shot, SurfaceMotion motion, const std::string& backend) {
  std::vector<std::string> out{"all",
                               backend,
                               name_of(motion),
                               name_of(shot.target),
                               shot.tool.radius > 0 ? "spheres" : "points",
                               shot.speed < 1    ? "0.1 to 1 m/s"
                               : shot.speed < 10 ? "1 to 10 m/s"
                                                 : "10 to 50 m/s"};
  if (shot.at_boundary) out.push_back("at the end of a tick");
  out.push_back(shot.from_behind ? "aimed from behind" : "aimed from outside");
  return out;
}

std::vector<std::string> available_backends() {
  std::vector<std::string> out;
  for (const BackendInfo& b : triangle_index_backends())
    if (b.available) out.push_back(b.name);
  return out;
}

Row shoot_at(const TargetMesh& target, long shots, unsigned seed, Rows& kinds) {
  using Clock = std::chrono::steady_clock;
  const std::vector<std::string> backends = available_backends();
  std::vector<std::unique_ptr<TriangleIndex>> indices;
  for (const std::string& name : backends) {
    indices.push_back(make_triangle_index(name));
    indices.back()->build(target.mesh.triangles, target.mesh.x);
  }
  Sample s{std::mt19937_64(seed)};
  Row out;
  const auto start = Clock::now();
  for (long salvo = 0; out.count.shots < shots; ++salvo) {
    const auto motion = static_cast<SurfaceMotion>(salvo % 3);
    const std::size_t backend = static_cast<std::size_t>(salvo / 3) % backends.size();
    const SurfaceTicks surface = random_ticks(s, target.mesh.triangles, target.mesh.x, motion);
    std::vector<Shot> salvo_shots;
    for (long i = 0; i < std::min<long>(kSalvo, shots - out.count.shots); ++i)
      salvo_shots.push_back(random_shot(s, surface));
    const std::vector<ShotResult> results = shoot(surface, salvo_shots, *indices[backend]);
    for (std::size_t i = 0; i < results.size(); ++i) {
      const ShotCount& one = results[i].count;
      out.count.add(one);
      for (const std::string& kind : kinds_of(salvo_shots[i], motion, backends[backend])) kinds[kind].count.add(one);
      if (one.leaks || one.late || one.apart)
        std::printf("%s: %s, radius %.17g: %s\n", target.name.c_str(),
                    one.leaks  ? "leak"
                    : one.late ? "late"
                               : "no contact",
                    salvo_shots[i].tool.radius, to_text(results[i].query).c_str());
    }
  }
  out.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return out;
}

void print_head(const char* what) {
  std::printf("%-32s %9s %8s %8s %8s %6s %6s | %8s %7s %6s %5s %7s\n", what, "triangles", "shots", "through", "hits",
              "leaks", "late", "behind", "inside", "apart", "gap", "s");
}

void print(const std::string& name, long triangles, const Row& row) {
  const ShotCount& c = row.count;
  std::printf("%-32s %9s %8ld %8ld %8ld %6ld %6ld | %8ld %7ld %6ld %5.2f %7s\n", name.c_str(),
              triangles ? std::to_string(triangles).c_str() : "", c.shots, c.through, c.hits, c.leaks, c.late, c.behind,
              c.inside, c.apart, c.gap, row.seconds > 0 ? std::to_string(row.seconds).substr(0, 6).c_str() : "");
  std::fflush(stdout);
}

std::string csv_line(const std::string& name, long triangles, const Row& row) {
  const ShotCount& c = row.count;
  char text[256];
  std::snprintf(text, sizeof text, "%s,%ld,%ld,%ld,%ld,%ld,%ld,%ld,%ld,%ld,%.3g,%.1f\n", name.c_str(), triangles,
                c.shots, c.through, c.hits, c.leaks, c.late, c.behind, c.inside, c.apart, c.gap, row.seconds);
  return text;
}

bool run(const Options& options) {
  std::vector<std::string> places{KT_SOURCE_DIR "/meshes", KT_SOURCE_DIR "/meshes/broken"};
  places.insert(places.end(), options.meshes.begin(), options.meshes.end());
  if (!options.csv.empty()) require_writable(options.csv);
  const std::vector<TargetMesh> targets = load_targets(mesh_files(places));
  const auto count = static_cast<long>(targets.size());
  Rows kinds;
  Row all;
  std::string csv = "mesh,triangles,shots,through,hits,leaks,late,behind,inside,apart,gap,seconds\n";
  print_head("mesh");
  for (long i = 0; i < count; ++i) {
    const TargetMesh& target = targets[static_cast<std::size_t>(i)];
    const long shots = options.shots * (i + 1) / count - options.shots * i / count;
    const Row row = shoot_at(target, shots, options.seed + static_cast<unsigned>(i), kinds);
    const auto triangles = static_cast<long>(target.mesh.triangles.size());
    print(target.name, triangles, row);
    csv += csv_line(target.name, triangles, row);
    all.count.add(row.count);
    all.seconds += row.seconds;
  }
  print_head("kind");
  for (const auto& [name, row] : kinds) print(name, 0, row);
  for (const auto& [name, row] : kinds) csv += csv_line("(" + name + ")", 0, row);
  std::printf("%ld meshes, %.0f s\n", count, all.seconds);
  if (!options.csv.empty()) write_named_file(options.csv, csv);
  return !all.count.leaks && !all.count.late && !all.count.apart;
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  kt::Options options;
  CLI::App app;
  app.add_option("--shots", options.shots)->check(CLI::PositiveNumber);
  app.add_option("--seed", options.seed)->check(CLI::PositiveNumber);
  app.add_option("--csv", options.csv);
  app.add_option("meshes", options.meshes, "meshes and folders");
  CLI11_PARSE(app, argc, argv);
  try {
    return kt::run(options) ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tunnelling_table: %s\n", error.what());
    return 2;
  }
}
