#pragma once
// A session brought into steady sliding contact, tick by tick: what the benchmarks of the haptic side measure on.
#include <filesystem>
#include <map>
#include <vector>

#include "haptics/refresh/refresher.hpp"
#include "haptics/session/session.hpp"
#include "io/files/output_file.hpp"
#include "io/mesh/mesh_formats.hpp"

namespace kt {

constexpr double kPressed = 0.2;  // [s]

/// scenes/slab_drag.json with another mesh, tool and number of rings, dragged to and fro over the middle of the slab
/// (0.1 x 0.1 x 0.03 m).
inline Scene slab_drag(const std::string& mesh, const std::string& shape, int rings) {
  Scene scene;
  scene.object.mesh = KT_SOURCE_DIR "/meshes/" + mesh;
  scene.tool.shape = shape;
  scene.local.rings = rings;
  const bool is_point =
      shape == "point";  // it makes a sharp dent: deeper than 3 mm tetrahedra turn inside out under it
  const double top = 0.03 + (is_point ? 0 : scene.tool.radius), z = top - (is_point ? 0.002 : 0.004);
  std::vector<Waypoint> path{{0, {0.03, 0.05, top + 0.002}}, {kPressed, {0.03, 0.05, z}}};
  for (int i = 1; i <= 20; ++i) path.push_back({kPressed + 0.8 * i, {i % 2 ? 0.07 : 0.03, 0.05, z}});
  scene.tool.path.press_drag.reset();
  scene.tool.path.waypoints = path;
  scene.local.reducer = "wall";
  if (!KT_WITH_EMBREE) scene.collision.backend = "brute_force";
  return scene;
}

/// Blocks of finite elements as large as the slab, to see what a body's size costs: 1280, 3703 and 10240 nodes.
struct BlockCells {
  int across, up;
};
constexpr BlockCells kBlocks[] = {{15, 4}, {22, 6}, {31, 9}};

/// The same drag, a sphere 2 mm deep, over a neo-Hookean block. Its mesh is written to the temporary folder: a scene
/// names a file.
inline Scene block_drag(const BlockCells& cells, const std::string& reducer, int rings) {
  Mesh mesh = kuhn_block(cells.across, cells.across, cells.up, 0.1 / cells.across);
  for (Eigen::Index i = 2; i < mesh.x.size(); i += 3) mesh.x[i] *= 0.03 / (0.1 / cells.across * cells.up);
  const auto file = std::filesystem::temp_directory_path() / text("kilotouch_block_", mesh.num_nodes(), ".msh");
  write_file_whole(file.string(), write_msh(mesh));
  Scene scene = slab_drag("", "sphere", rings);
  scene.object.mesh = file.string();
  scene.object.model.type = "fem";
  scene.local.reducer = reducer;
  for (Waypoint& w : *scene.tool.path.waypoints)
    if (w.t >= kPressed) w.position.z() += 0.002;
  return scene;
}

/// The reducers whose local models are small enough to step, those that this build has.
struct NamedReducer {
  const char *name, *reducer;
  int rings;
};
inline std::vector<NamedReducer> tick_reducers() {
  std::vector<NamedReducer> out;
  for (const NamedReducer& r :
       {NamedReducer{"wall1", "wall", 1}, NamedReducer{"wall3", "wall", 3}, NamedReducer{"condensed", "condensed", 1},
        NamedReducer{"krylov", "krylov", 1}, NamedReducer{"modal", "modal", 1}, NamedReducer{"auto", "auto", 1}})
    for (const BackendInfo& known : reducer_backends())
      if (known.name == std::string(r.reducer)) out.push_back(r);
  return out;
}

/// A session a scene, kept: the mesh and its calibration take seconds.
inline const Session& session_of(const Scene& scene) {
  static std::map<std::string, Session> made;
  return made.try_emplace(scene.object.mesh + scene.tool.shape, scene).first->second;
}

/// Both rates in lockstep, as a session runs them, but with the tick in the caller's hands.
class SteadyDrag {
 public:
  explicit SteadyDrag(const Scene& scene)
      : session(session_of(scene)),
        surface(make_surface(session.model().mesh())),
        tool(scene.tool.shape == "point" ? ToolShape{ToolShape::Kind::point, 0}
                                         : ToolShape{ToolShape::Kind::sphere, scene.tool.radius}),
        // Reach and interval as in Session::run.
        refresher(session.model(), surface, session.options(), session.start()),
        local(tool, 1 / scene.local.rate_hz,
              make_contact_solver(scene.contact.law, {scene.contact.mu_static, scene.contact.mu_kinetic})),
        every_(static_cast<int>(scene.local.rate_hz / scene.global.rate_hz)) {
    while (tick_ * local.h() < kPressed + 0.1) {
      refresh_when_due();
      step();
    }
  }

  /// The slow side, when it is its turn. Not part of the tick.
  void refresh_when_due() {
    if (tick_ % every_ != 0) return;
    local.adopt(refresher.refresh(tick_ * local.h(), std::array{Pose{place(tick_)}}, reports_));
    records.push_back(refresher.record());
    reports_.clear();
  }

  ToolSweep sweep() const { return {place(tick_), place(tick_ + 1)}; }

  /// The tick itself.
  LocalFrame step() {
    const LocalFrame frame = local.step(sweep());
    LocalReport report;
    report.tick = tick_++;
    report.tools[0].pose.x = place(tick_);
    report.tools[0].triangle = frame.mode == ContactMode::free ? -1 : frame.triangle;
    report.model_frame = local.model().model.frame;
    for (const TickContact& sample : local.samples()) report.samples[report.count++] = sample;
    reports_.push_back(report);
    return frame;
  }

  const Session& session;
  Surface surface;
  ToolShape tool;
  Refresher refresher;
  std::vector<RefreshRecord> records;  ///< of each refresh
  LocalSimulation local;

 private:
  Vec3 place(int tick) const { return interpolate_path(session.path(), tick * local.h()); }
  int every_, tick_ = 0;
  std::vector<LocalReport> reports_;
};

}  // namespace kt
