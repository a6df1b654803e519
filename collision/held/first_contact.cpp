#include "collision/held/first_contact.hpp"

#include <array>
#include <ranges>

namespace kt {

namespace {

/// A hair more than the radius: the narrow phase may see contact within its rounding.
double margin_of(double radius, double size) noexcept { return radius * (1 + 1e-12) + 1e-14 * size; }

template <class Impact>
std::optional<Contact> earliest(const MovingTriangles& surface, std::span<const int> candidates,
                                std::span<const unsigned char> ignored, const Impact& impact) noexcept {
  std::optional<Contact> first;
  for (const int t : candidates) {
    if (!ignored.empty() && ignored[t]) continue;
    const Triangle& v = surface.triangles[t];
    const Vec3 t0[3] = {node(surface.x_t0, v[0]), node(surface.x_t0, v[1]), node(surface.x_t0, v[2])};
    const Vec3 t1[3] = {node(surface.x_t1, v[0]), node(surface.x_t1, v[1]), node(surface.x_t1, v[2])};
    const std::optional<Contact> hit = impact(t0, t1, first ? first->toi : 1);
    // Candidates ascend, so of equal times the lowest index stays.
    if (hit && (!first || hit->toi < first->toi)) {
      first = hit;
      first->triangle = t;
    }
  }
  return first;
}

/// The earliest of some pieces of a tool.
template <class Hulls>
std::optional<Contact> find_impact_of(const MovingTool& tool, const Hulls& hulls, const Vec3 (&triangle_t0)[3],
                                      const Vec3 (&triangle_t1)[3], double until) noexcept {
  Box box{triangle_t0[0], triangle_t0[0]};
  for (const Vec3& x : {triangle_t0[1], triangle_t0[2], triangle_t1[0], triangle_t1[1], triangle_t1[2]}) {
    box.low = box.low.cwiseMin(x);
    box.high = box.high.cwiseMax(x);
  }
  const double margin =
      margin_of(tool.shape().radius, box.low.lpNorm<Eigen::Infinity>() + box.high.lpNorm<Eigen::Infinity>());
  box.low.array() -= margin;
  box.high.array() += margin;
  std::optional<Contact> first;
  for (const int i : hulls) {
    if (is_apart(box, tool.hull_box(i))) continue;
    const std::optional<Contact> hit = find_hull_impact(tool.hull(i), triangle_t0, triangle_t1, until);
    if (!hit || (first && hit->toi >= first->toi)) continue;
    first = hit;
    until = hit->toi;
  }
  return first;
}

/// The pieces of a tool that come near any of the triangles, ascending: of a mesh that lies flat one side in six.
class NearHulls {
 public:
  NearHulls(const MovingTriangles& surface, std::span<const int> candidates, std::span<const unsigned char> ignored,
            const MovingTool& tool, double margin) noexcept {
    Box box{Vec3::Constant(std::numeric_limits<double>::infinity()), {}};
    box.high = -box.low;
    bool is_finite = true;
    for (const int t : candidates) {
      if (!ignored.empty() && ignored[t]) continue;
      const Box own = swept_box(surface.triangles[t], surface.x_t0, surface.x_t1);
      is_finite = is_finite && own.low.allFinite() && own.high.allFinite();
      box.low = box.low.cwiseMin(own.low);
      box.high = box.high.cwiseMax(own.high);
    }
    box.low.array() -= 2 * margin;  // that of a triangle is a hair different
    box.high.array() += 2 * margin;
    for (int i = 0; i < tool.num_hulls(); ++i) {
      if (is_finite && is_apart(box, tool.hull_box(i))) continue;
      if (count_ == kMost) {
        holds_all_ = true;
        return;
      }
      hulls_[count_++] = i;
    }
  }
  bool holds_all() const noexcept { return holds_all_; }  ///< there are too many: it is all of them
  std::span<const int> hulls() const noexcept { return {hulls_.data(), static_cast<std::size_t>(count_)}; }

 private:
  static constexpr int kMost = 512;
  std::array<int, kMost> hulls_;
  int count_ = 0;
  bool holds_all_ = false;
};

}  // namespace

std::optional<Contact> find_first_contact(const TriangleIndex& index, const MovingTriangles& surface,
                                          const ToolShape& tool, const ToolSweep& sweep,
                                          std::span<const unsigned char> ignored, std::span<int> scratch) noexcept {
  const double size = sweep.x_t0.lpNorm<Eigen::Infinity>() + sweep.x_t1.lpNorm<Eigen::Infinity>();
  const int count = index.candidates(sweep, margin_of(tool.radius, size), scratch);
  return earliest(surface, scratch.first(static_cast<std::size_t>(count)), ignored,
                  [&](const auto& t0, const auto& t1, double) { return find_triangle_impact(tool, sweep, t0, t1); });
}

std::optional<Contact> find_first_contact(const TriangleIndex& index, const MovingTriangles& surface,
                                          const MovingTool& tool, std::span<const unsigned char> ignored,
                                          std::span<int> scratch) noexcept {
  if (tool.is_round()) return find_first_contact(index, surface, tool.shape(), tool.sweep(), ignored, scratch);
  const Box& box = tool.box();
  const double size = box.low.lpNorm<Eigen::Infinity>() + box.high.lpNorm<Eigen::Infinity>();
  const double margin = margin_of(tool.shape().radius, size);
  const auto candidates =
      scratch.first(static_cast<std::size_t>(index.candidates({box.low, box.high}, margin, scratch)));
  const NearHulls near(surface, candidates, ignored, tool, margin);
  return earliest(surface, candidates, ignored, [&](const auto& t0, const auto& t1, double until) {
    return near.holds_all() ? find_tool_impact(tool, t0, t1, until) : find_impact_of(tool, near.hulls(), t0, t1, until);
  });
}

std::optional<Contact> find_tool_impact(const MovingTool& tool, const Vec3 (&triangle_t0)[3],
                                        const Vec3 (&triangle_t1)[3], double until) noexcept {
  if (tool.is_round()) return find_triangle_impact(tool.shape(), tool.sweep(), triangle_t0, triangle_t1);
  return find_impact_of(tool, std::views::iota(0, tool.num_hulls()), triangle_t0, triangle_t1, until);
}

}  // namespace kt
