// What a tick costs by tool and surface: CPU time of the ticks of a press and drag over scenes/slab_drag.json, in
// lockstep, once the tool has been pressed in; with it how deep the tool was in the whole body and how the force jumps.
//   build/release/bench/tick_tools_table [--tool NAME] [--surface flat|loop] [--levels N] [--reducer NAME]
//       [--duration S] [--mesh FILE] [--trace FOLDER] [--scene FILE] [--rate HZ]
// --scene: that one alone, as it is but for --rate, `local.rate_hz`.
// --trace: time, force and torque of each tick as FOLDER/<tool>_<surface>.csv, to compare two programs.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "haptics/session/metrics.hpp"
#include "haptics/session/session.hpp"
#include "io/files/output_file.hpp"
#include "io/mesh/mesh_formats.hpp"
#include "io/scene/scene.hpp"
#include "tests/support/tool_shapes.hpp"

namespace kt {
namespace {

struct Options {
  std::string tool, surface, reducer = "condensed", mesh = KT_SOURCE_DIR "/meshes/slab_coarse.off", trace, scene;
  double rate_hz = 1000;
  int levels = 1;
  double duration = 0.6;
};

constexpr double kPressed = 0.25;  // [s] from then on ticks count

/// A box that lies flat, of 192 triangles, as a file: a scene names one.
std::string box_file() {
  const ToolShape box = box_tool({8e-3, 5e-3, 2e-3}, 4, 1e-3);
  Mesh mesh;
  mesh.triangles = box.triangles;
  mesh.x.resize(3 * static_cast<Eigen::Index>(box.corners.size()));
  for (std::size_t i = 0; i < box.corners.size(); ++i) node(mesh.x, static_cast<int>(i)) = box.corners[i];
  const auto file = std::filesystem::temp_directory_path() / "kilotouch_box_tool.off";
  write_file_whole(file.string(), write_off(mesh));
  return file.string();
}

struct Row {
  const char *tool, *surface;
};
constexpr Row kRows[] = {{"point", "flat"},   {"point", "loop"},   {"sphere", "flat"}, {"sphere", "loop"},
                         {"capsule", "flat"}, {"capsule", "loop"}, {"mesh", "flat"},   {"mesh", "loop"}};

Scene scene_of(const Row& row, const Options& options) {
  Scene scene = options.scene.empty() ? Scene{} : load_scene(options.scene);
  scene.local.rate_hz = options.rate_hz;
  if (!options.scene.empty()) return scene;
  scene.duration = options.duration;
  scene.object.mesh = options.mesh;
  scene.local.reducer = options.reducer;
  scene.contact.surface = row.surface;
  scene.contact.surface_levels = options.levels;
  scene.tool.shape = row.tool;
  double height = scene.tool.radius, depth = 3e-3;  // of the reference point over a plane that it touches
  if (scene.tool.shape == "point") {
    height = 0;
    depth = 2e-3;
  } else if (scene.tool.shape == "capsule") {
    scene.tool.turn = {0, M_PI / 2, 0};
  } else if (scene.tool.shape == "mesh") {
    scene.tool.mesh = box_file();
    scene.tool.scale = 1;
    scene.tool.radius = 1e-3;
    height = 3e-3;
    depth = 2e-3;
  }
  const double z = 0.03 + height - depth, way = 0.05 * (options.duration - 0.2);
  scene.tool.path.press_drag.reset();
  scene.tool.path.waypoints = std::vector<Waypoint>{{0, {0.04, 0.05, z + depth + 1e-3}},
                                                    {0.2, {0.04, 0.05, z}},
                                                    {options.duration, {0.04 + way, 0.05 + 0.3 * way, z}}};
  return scene;
}

void write_trace(const SessionResult& result, const std::string& file) {
  std::ofstream out(file);
  out.precision(17);
  out << "t,fx,fy,fz,mx,my,mz,contacts,us\n";
  for (std::size_t i = 0; i < result.tools[0].frames.size(); ++i) {
    const LocalFrame& f = result.tools[0].frames[i];
    out << f.t << ',' << f.force[0] << ',' << f.force[1] << ',' << f.force[2] << ',' << f.torque[0] << ','
        << f.torque[1] << ',' << f.torque[2] << ',' << f.contacts << ',' << result.step_us[i] << '\n';
  }
}

void run(const Row& row, const Options& options) {
  Session session(scene_of(row, options));
  const SessionResult result = session.run();
  std::vector<double> us;
  double contacts = 0, residual = 0, deepest = 0, force = 0, jump = 0;
  int unsolved = 0;
  for (std::size_t i = 0; i < result.tools[0].frames.size(); ++i) {
    const LocalFrame& f = result.tools[0].frames[i];
    deepest = std::max(deepest, result.tools[0].penetration[i]);
    if (f.t < kPressed) continue;
    us.push_back(result.step_us[i]);
    contacts += f.contacts;
    force += f.force.norm();
    residual = std::max(residual, f.residual);
    unsolved += f.residual > 1e-6;
    jump = std::max(jump, (f.force - result.tools[0].frames[i - 1].force).norm());
  }
  const auto n = static_cast<double>(us.size());
  std::printf("%-8s %-5s %5d %4d %6.1f | %7.1f %7.1f %7.1f %7.1f | %9.2e %7.4f %6.2f %4d %8.1e\n", row.tool,
              row.surface, result.last_dof, result.last_patch_vertices, contacts / n, percentile(us, 0.5),
              percentile(us, 0.99), percentile(us, 0.999), percentile(us, 1), deepest, force / n,
              100 * jump / (force / n), unsolved, residual);
  std::fflush(stdout);
  if (!options.trace.empty()) write_trace(result, options.trace + "/" + row.tool + "_" + row.surface + ".csv");
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  kt::Options options;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string word = argv[i], value = argv[i + 1];
    if (word == "--tool") options.tool = value;
    if (word == "--surface") options.surface = value;
    if (word == "--reducer") options.reducer = value;
    if (word == "--mesh") options.mesh = value;
    if (word == "--trace") options.trace = value;
    if (word == "--scene") options.scene = value;
    if (word == "--rate") options.rate_hz = std::stod(value);
    if (word == "--levels") options.levels = std::stoi(value);
    if (word == "--duration") options.duration = std::stod(value);
  }
  std::printf(
      "tool     surf    dof vert places |   p50 us     p99   p99.9     max |  deepest  force N jump %% >1e-6 "
      "residual\n");
  if (!options.scene.empty()) {
    kt::run({"scene", ""}, options);
    return 0;
  }
  for (const kt::Row& row : kt::kRows)
    if ((options.tool.empty() || options.tool == row.tool) &&
        (options.surface.empty() || options.surface == row.surface))
      kt::run(row, options);
  return 0;
}
