#pragma once
// Short runs of a whole session on a small slab, for the maps of contact, hand and link.
#include "haptics/session/metrics.hpp"
#include "haptics/session/session.hpp"
#include "lab/stability/map.hpp"

namespace kt {

/// 40 x 30 x 10 mm of soft tissue, clamped below, and a ball of 2 mm radius that is pressed 1.5 mm in and dragged. The
/// mesh is slab_mesh(); the scene names none.
Scene slab_scene();

/// @param edge  of its cubes [m]: the slab's sides are whole numbers of 2.5, 5 mm; others round to the nearest
Mesh slab_mesh(double edge);

struct SessionRun {
  SessionResult result;
  ForceMetrics force;
  std::vector<Prediction> predictions;  ///< made before the run
  double deepest = 0;                   ///< of the tool in the body [m]
  unsigned flags = 0;                   ///< of all ticks
  std::string error;                    ///< of a run that threw
};

/// Sets up, predicts, runs. In one thread, without its own progress. Its last tick is a snapshot.
/// @param map  predictions that this map shows: others are of other maps
SessionRun run_session(const std::string& map, const Scene& scene, const Mesh& mesh, const MapOptions& options);

/// What the tool feels wrong at once, in words; empty: nothing. What ends a run's use, whatever the map.
std::string failure_of(const SessionRun& run);

/// A point with what was predicted, and the run's hash.
MapPoint point_of(const std::string& series, double x, double y, const SessionRun& run);

}  // namespace kt
