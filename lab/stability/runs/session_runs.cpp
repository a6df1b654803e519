#include "lab/stability/runs/session_runs.hpp"

#include <algorithm>
#include <cmath>

#include "lab/stability/runs/rays.hpp"

namespace kt {

Scene slab_scene() {
  Scene scene = default_scene();
  scene.title = "slab";
  scene.duration = 0.3;
  scene.object.mesh = "slab";
  scene.object.model.young = 1e4;
  scene.tool.shape = "sphere";
  scene.tool.radius = 0.002;
  scene.tool.path.press_drag = PressDrag{.at = std::array<double, 2>{0.0131, 0.0143},
                                         .depth = 0.0015,
                                         .press_time = 0.06,
                                         .direction = {1, 0.2, 0},
                                         .speed = 0.05};
  scene.local.refine = std::string("off");  // of the method; cells under the tool are the mesh's
  scene.global.early_refresh = false;       // as often as the scene says: half the time
  scene.local.reducer = "condensed";        // the default, auto, certifies eight of them first
  return scene;
}

Mesh slab_mesh(double edge) {
  const auto cells = [&](double length) { return std::max(1, static_cast<int>(std::lround(length / edge))); };
  return kuhn_block(cells(0.04), cells(0.03), cells(0.01), edge);
}

SessionRun run_session(const std::string& map, const Scene& scene, const Mesh& mesh, const MapOptions& options) {
  SessionRun out;
  try {
    Session session(scene, mesh);
    out.predictions = session.predictions();
    std::erase_if(out.predictions, [&](const Prediction& p) { return p.failure != map; });
    SessionOptions run_options;
    run_options.stop = options.stop;
    run_options.snapshot_times = {scene.duration - 1.5 / scene.local.rate_hz};
    out.result = session.run(run_options);
  } catch (const std::runtime_error& e) {
    out.error = e.what();
    return out;
  }
  // The drag's first part, while the body gets into motion, is not judged.
  const double pressed = scene.tool.path.press_drag ? scene.tool.path.press_drag->press_time : 0,
               settled = pressed > 0 ? pressed + std::min(0.04, 0.25 * (scene.duration - pressed)) : 0;
  out.force = measure_forces(out.result.tools[0].frames, settled, 1 / scene.local.rate_hz);
  for (double depth : out.result.tools[0].penetration) out.deepest = std::max(out.deepest, depth);
  for (const LocalFrame& f : out.result.tools[0].frames) out.flags |= f.flags;
  return out;
}

std::string failure_of(const SessionRun& run) {
  if (!run.error.empty()) return run.error;
  if (run.flags & kNotFinite) return "not finite: the local model was reset";
  const bool touched = run.force.ticks_free < static_cast<int>(run.result.tools[0].frames.size());
  if (!touched) return "no contact";
  return "";
}

MapPoint point_of(const std::string& series, double x, double y, const SessionRun& run) {
  MapPoint out = point_at(series, x, y);
  out.predicted_failure = !run.predictions.empty();
  for (const Prediction& p : run.predictions) out.prediction += (out.prediction.empty() ? "" : "; ") + p.message();
  out.hash = run.result.hash;
  return out;
}

}  // namespace kt
