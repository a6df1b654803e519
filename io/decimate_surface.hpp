#pragma once
// The same surface with fewer triangles, by collapsing edges (Lindstrom and Turk 1998: keeps volume and borders).
#include <atomic>

#include "core/mesh.hpp"

namespace kt {

struct DecimateOptions {
  double timeout = 60;                      ///< of the child process that does it [s], > 0
  const std::atomic<bool>* stop = nullptr;  ///< when set and true: RunError "interrupted"
};

/// With at most `triangles` triangles, or as few as collapsing leaves: pieces, handles and holes stay. The surface must
/// be manifold and oriented; it may be open. It can cross itself afterwards: examine() the result, and measure how far
/// it moved with hausdorff_distance().
/// @throws InputError without CGAL; RunError for a surface that is not manifold, or when it takes too long
Mesh decimate_surface(const Mesh& surface, int triangles, const DecimateOptions& options = {});

/// The part that needs CGAL.
Mesh decimate_cgal(const Mesh& surface, int triangles);

}  // namespace kt
