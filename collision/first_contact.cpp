#include "collision/first_contact.hpp"

namespace kt {

std::optional<Contact> find_first_contact(const TriangleIndex& index, const MovingTriangles& surface,
                                          const ToolShape& tool, const ToolSweep& sweep,
                                          std::span<const unsigned char> ignored, std::span<int> scratch) noexcept {
  // A hair more than the radius: the narrow phase may see contact within its rounding.
  const double size = sweep.x_t0.lpNorm<Eigen::Infinity>() + sweep.x_t1.lpNorm<Eigen::Infinity>();
  const double margin = tool.radius * (1 + 1e-12) + 1e-14 * size;
  const int count = index.candidates(sweep, margin, scratch);
  std::optional<Contact> first;
  for (int i = 0; i < count; ++i) {
    const int t = scratch[i];
    if (!ignored.empty() && ignored[t]) continue;
    const Triangle& v = surface.triangles[t];
    const Vec3 t0[3] = {node(surface.x_t0, v[0]), node(surface.x_t0, v[1]), node(surface.x_t0, v[2])};
    const Vec3 t1[3] = {node(surface.x_t1, v[0]), node(surface.x_t1, v[1]), node(surface.x_t1, v[2])};
    auto hit = find_triangle_impact(tool, sweep, t0, t1);
    // Candidates ascend, so of equal times the lowest index stays.
    if (hit && (!first || hit->toi < first->toi)) {
      first = hit;
      first->triangle = t;
    }
  }
  return first;
}

}  // namespace kt
