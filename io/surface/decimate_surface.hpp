#pragma once
// The same surface with fewer triangles, by collapsing edges (quadrics of Garland and Heckbert 1997), none of them
// slivers.
#include <atomic>

#include "core/body/mesh.hpp"

namespace kt {

struct DecimateOptions {
  bool evenly = false;  ///< long triangles are split first, and collapses cost something on flat parts, too (quadrics
                        ///< of uncertain normals: Trettner and Kobbelt 2020): edges alike, further off. For surfaces
                        ///< from CAD, whose long triangles leave only flat tetrahedra
  double timeout = 60;  ///< of the child process that does it [s], > 0
  const std::atomic<bool>* stop = nullptr;  ///< when set and true: RunError "interrupted"
};

/// With at most `triangles` triangles, or as few as collapsing leaves: pieces, handles and holes stay. No triangle gets
/// flatter than 0.2 (smallest altitude by longest edge) where none was, unless that would move the surface more than
/// twice as far and 0.1 % of its size. It must be manifold and oriented; it may be open. It can cross itself
/// afterwards: examine() the result, and measure how far it moved with hausdorff_distance().
/// @throws InputError without CGAL; RunError for a surface that is not manifold, or when it takes too long
Mesh decimate_surface(const Mesh& surface, int triangles, const DecimateOptions& options = {});

/// The part that needs CGAL.
Mesh decimate_cgal(const Mesh& surface, int triangles, bool evenly);

}  // namespace kt
