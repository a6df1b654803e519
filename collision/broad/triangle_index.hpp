#pragma once
// Broad phase: which triangles can the tool meet during this step? Backends: triangle_index.def.
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "collision/shape/contact.hpp"
#include "core/base/backend.hpp"

namespace kt {

/// Finds a superset of the triangles near a swept tool. Built and first fitted at a refresh (may allocate);
/// refit(), refit_moved() and candidates() run in the haptic tick: no allocation, no exception.
/// Triangles are taken as they come: duplicated, degenerate, non-manifold. A vertex that is not finite is everywhere.
class TriangleIndex {
 public:
  virtual ~TriangleIndex() = default;

  /// Adopts new connectivity over p moving vertices, fitted to positions x (3p). May allocate.
  virtual void build(std::span<const Triangle> triangles, const VectorX& x) = 0;

  /// Follows the vertices from x_t0 to x_t1 (both (3p)): boxes enclose both ends, rounded outward.
  virtual void refit(const VectorX& x_t0, const VectorX& x_t1) noexcept = 0;

  /// The same as refit(x_t0, x_t1), told that no vertex but `vertices` differs from the last refit, at either end: also
  /// list those that have come to rest since. Any order, repeated or not. Pays where few of many vertices move; what
  /// has no better way refits everything.
  virtual void refit_moved([[maybe_unused]] std::span<const int> vertices, const VectorX& x_t0,
                           const VectorX& x_t1) noexcept {
    refit(x_t0, x_t1);
  }

  /// Writes the ascending indices of every triangle whose swept box comes within `margin` [m] of the segment's box;
  /// at least all that the tool can touch. Returns how many were written (<= out.size(), which must hold all
  /// triangles).
  virtual int candidates(const ToolSweep& sweep, double margin, std::span<int> out) const noexcept = 0;
};

/// The table of collision backends, in the order of the .def file.
std::vector<BackendInfo> triangle_index_backends();

/// Makes an index by name; InputError for an unknown name or one that this build lacks.
std::unique_ptr<TriangleIndex> make_triangle_index(const std::string& name);

}  // namespace kt
