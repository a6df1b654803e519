#pragma once
// Closest points and rays of a broad phase against looking at every triangle.
#include <vector>

#include "lab/check/surface_query.hpp"

namespace kt {

struct QueryCount {
  int points = 0, rays = 0;
  int hits = 0;               ///< rays that meet the surface from its front, certainly
  int wrong_points = 0;       ///< nearest place further away than the nearest of all
  int wrong_rays = 0;         ///< the first crossing missed, or another one reported
  double worst_point = 0;     ///< distance too much, of the size
  double worst_ray = 0;       ///< of the rays that agree: difference of the crossings, of the ray
  std::optional<Vec3> where;  ///< of the first that is wrong
  void add(const QueryCount& other);
};

/// A point and its distance, a ray and its first crossing, both by looking at every triangle.
struct QueryTruth {
  Vec3 point;
  double distance;
  Vec3 from, to;
  std::optional<double> crossing;  ///< from the front, share of the ray
  bool sure;                       ///< no other crossing, edge or graze is near it or before
};

std::vector<QueryTruth> true_queries(std::span<const Triangle> triangles, const VectorX& x, int count, unsigned seed);

/// @param index  built and fitted to the surface at rest
QueryCount judge_queries(std::span<const Triangle> triangles, const VectorX& x, const TriangleIndex& index,
                         std::span<const QueryTruth> truths);

}  // namespace kt
