#pragma once
// Closest points and crossings of a surface at rest: with a broad phase, and by looking at every triangle.
#include <memory>
#include <optional>
#include <span>

#include "collision/broad/triangle_index.hpp"
#include "collision/shape/closest_point.hpp"

namespace kt {

struct NearestPlace {
  int triangle = -1;
  ClosestPoint at;
};

/// The nearest place of some triangles; ties go to the earliest.
NearestPlace nearest_place(std::span<const Triangle> triangles, const VectorX& x, std::span<const int> candidates,
                           const Vec3& p);
NearestPlace nearest_place(std::span<const Triangle> triangles, const VectorX& x, const Vec3& p);

/// Where a segment goes through a triangle: share of its length, from which side.
struct SegmentCrossing {
  int triangle = -1;
  double share = 0;
  bool from_front = false;
};

/// Of the triangle and the segment a b, in long double; `margin` is how far inside the triangle (least weight).
std::optional<SegmentCrossing> crossing_of(const Vec3& a, const Vec3& b, const Vec3 (&triangle)[3], double* margin);

/// A surface with a broad phase of its own.
class SurfaceQuery {
 public:
  SurfaceQuery(std::span<const Triangle> triangles, const VectorX& x, const std::string& backend = "refit_bvh");
  /// @param guess  a distance that the answer may have [m], > 0; it grows until something is found
  NearestPlace nearest(const Vec3& p, double guess) const;
  double distance(const Vec3& p, double guess) const { return std::sqrt(nearest(p, guess).at.distance_sq); }
  /// Whether something of the surface is nearer than this.
  bool is_within(const Vec3& p, double distance) const;
  /// The first crossing of the segment from either side, beyond the share `from` of it.
  std::optional<SegmentCrossing> crossing(const Vec3& a, const Vec3& b, double from) const;
  const TriangleIndex& index() const { return *index_; }
  std::span<const Triangle> triangles() const { return triangles_; }
  const VectorX& x() const { return x_; }

 private:
  std::span<const Triangle> triangles_;
  const VectorX& x_;
  double size_ = 0;
  std::unique_ptr<TriangleIndex> index_;
  mutable std::vector<int> scratch_;
};

}  // namespace kt
