#pragma once
// Fixes what can be fixed without changing the shape, and says what it did. Wrapping changes the shape and is asked
// for.
#include <atomic>
#include <string>
#include <vector>

#include "core/body/mesh.hpp"

namespace kt {

struct RepairOptions {
  bool weld = true;                         ///< join nodes at equal positions
  double weld_tolerance = 0;                ///< and those at most so far apart [mesh unit]
  bool drop_degenerate = true;              ///< triangles without area whose removal opens no gap (two corners joined)
  bool drop_duplicates = true;              ///< second copies of a triangle
  bool split_nonmanifold = true;            ///< one copy of a node for every fan that touches in it
  bool orient = true;                       ///< agree inside each piece; closed pieces outward, cavities inward
  bool drop_isolated = true;                ///< nodes that nothing uses
  int fill_holes = 0;                       ///< close holes of at most this many edges (CGAL); 0: none
  double timeout = 120;                     ///< for hole filling [s]
  const std::atomic<bool>* stop = nullptr;  ///< when set and true: RunError "interrupted"
};

struct RepairResult {
  Mesh mesh;
  std::vector<std::string> done;  ///< "12 nodes at equal positions joined to 5", ...; empty: nothing to do
};

/// Repairs a surface, or joins the nodes of a solid and drops what occurs twice. Triangles without area that remain,
/// open edges beyond fill_holes, self-intersections and pieces that cannot be oriented stay as they are: examine() the
/// result. Triangles at NaN or infinite nodes are dropped.
/// @throws InputError for options out of range, for the holes of a solid, or for hole filling without CGAL.
RepairResult repair(const Mesh& surface, const RepairOptions& options = {});

struct WrapOptions {
  double alpha = 0;      ///< size of the ball that may not enter holes [mesh unit]; 0: box diagonal / 40
  double offset = 0;     ///< distance of the wrap from the input [mesh unit]; 0: alpha / 30
  double timeout = 300;  ///< [s]
  const std::atomic<bool>* stop = nullptr;  ///< when set and true: RunError "interrupted"
};

struct WrapResult {
  Mesh mesh;                     ///< closed, manifold, outward, free of self-intersections
  double alpha = 0, offset = 0;  ///< used [mesh unit]
  double volume_before = 0;      ///< of the input [unit^3]; meaningless when it was open
  double volume_after = 0;
  double distance_to_wrap = 0;   ///< largest distance from the input to the wrap [mesh unit], by sampling
  double distance_to_input = 0;  ///< and from the wrap to the input
};

/// Wraps any triangle soup with CGAL's alpha_wrap_3. Runs in a child process with a time limit.
/// @throws InputError without CGAL or for options out of range; RunError when the wrap fails or takes too long.
WrapResult wrap(const Mesh& surface, const WrapOptions& options = {});

}  // namespace kt
