#include "io/solid/lattice_grid.hpp"

#include <algorithm>
#include <cmath>

namespace kt {
namespace {

bool is_odd(const std::array<int, 3>& axes) {
  return (axes[0] > axes[1]) != ((axes[0] > axes[2]) != (axes[1] > axes[2]));
}

}  // namespace

std::array<int, 3> LatticeGrid::holding(const Vec3& place) const {
  std::array<int, 3> out{};
  for (int c = 0; c < 3; ++c)
    out[static_cast<std::size_t>(c)] = static_cast<int>(
        std::clamp((place[c] - origin[c]) / edge[c], 0.0, static_cast<double>(count[static_cast<std::size_t>(c)] - 1)));
  return out;
}

namespace {

/// Where nodes are to lie across an axis, since a part of the box is clamped up to there.
std::optional<double> end_across(int axis, const Bounds& box, double edge, const Bounds& clamped) {
  constexpr double kNear = 0.1;  // edges
  const Vec3 wide = clamped.max.cwiseMin(box.max) - clamped.min.cwiseMax(box.min);
  const auto is_narrow = [&](int other) { return wide[other] < std::min(edge, box.size()[other]); };
  if (box.size()[axis] < edge || is_narrow((axis + 1) % 3) || is_narrow((axis + 2) % 3)) return {};
  for (const double end : {clamped.min[axis], clamped.max[axis]})
    if (end - box.min[axis] > kNear * edge && box.max[axis] - end > kNear * edge) return end;
  return {};
}

}  // namespace

LatticeGrid make_lattice_grid(const Bounds& box, double edge, const std::optional<Bounds>& clamped) {
  constexpr double kRounding = 1e-9, kFlattest = 0.5;
  LatticeGrid out;
  out.origin = box.min;
  const auto cubes_in = [&](double size, double its) {
    return std::max(1, static_cast<int>(std::ceil(size / its - kRounding)));
  };
  for (int c = 0; c < 3; ++c) {
    int& count = out.count[static_cast<std::size_t>(c)];
    const double size = box.size()[c];
    if (const std::optional<double> end = clamped ? end_across(c, box, edge, *clamped) : std::nullopt) {
      const double below = *end - box.min[c], most = std::max(below, size - below);
      out.edge[c] = most / cubes_in(most, edge);
      const int cubes_below = cubes_in(below, out.edge[c]);
      count = cubes_below + cubes_in(size - below, out.edge[c]);
      out.origin[c] = *end - cubes_below * out.edge[c];
      continue;
    }
    count = cubes_in(size, edge);
    out.edge[c] = std::max(size / count, kFlattest * edge);
    if (out.edge[c] * count > size) out.origin[c] -= 0.5 * (out.edge[c] * count - size);
  }
  return out;
}

std::array<std::array<int, 3>, 4> kuhn_corners(int tetrahedron) {
  const auto& axes = kKuhnAxes[static_cast<std::size_t>(tetrahedron)];
  std::array<std::array<int, 3>, 4> out{};
  for (std::size_t i = 0; i < 3; ++i) {
    out[i + 1] = out[i];
    out[i + 1][static_cast<std::size_t>(axes[i])] = 1;
  }
  if (is_odd(axes)) std::swap(out[1], out[2]);
  return out;
}

std::array<double, 4> kuhn_weights(int tetrahedron, const Vec3& place) {
  const auto& axes = kKuhnAxes[static_cast<std::size_t>(tetrahedron)];
  const double a = place[axes[0]], b = place[axes[1]], c = place[axes[2]];
  std::array<double, 4> out{1 - a, a - b, b - c, c};
  if (is_odd(axes)) std::swap(out[1], out[2]);
  return out;
}

int kuhn_holding(const Vec3& place) {
  for (int t = 0; t < 6; ++t) {
    const auto& axes = kKuhnAxes[static_cast<std::size_t>(t)];
    if (place[axes[0]] >= place[axes[1]] && place[axes[1]] >= place[axes[2]]) return t;
  }
  return 0;
}

std::vector<char> touched_cubes(const LatticeGrid& grid, const Mesh& surface) {
  constexpr double kNearly = 1e-9;  // of an edge
  std::vector<char> out(static_cast<std::size_t>(grid.num_cubes()), 0);
  for (const Triangle& t : surface.triangles) {
    const Vec3 a = node(surface.x, t[0]), b = node(surface.x, t[1]), c = node(surface.x, t[2]);
    const Vec3 margin = kNearly * grid.edge;
    const auto low = grid.holding(a.cwiseMin(b).cwiseMin(c) - margin),
               high = grid.holding(a.cwiseMax(b).cwiseMax(c) + margin);
    if (low == high) {
      out[static_cast<std::size_t>(grid.cube(low))] = 1;
      continue;
    }
    const Vec3 normal = (b - a).cross(c - a);
    const double half = (0.5 + kNearly) * normal.cwiseAbs().dot(grid.edge);
    for (int z = low[2]; z <= high[2]; ++z)
      for (int y = low[1]; y <= high[1]; ++y)
        for (int x = low[0]; x <= high[0]; ++x) {
          const Vec3 middle = grid.corner({x, y, z}) + 0.5 * grid.edge;
          if (std::abs(normal.dot(middle - a)) <= half) out[static_cast<std::size_t>(grid.cube({x, y, z}))] = 1;
        }
  }
  return out;
}

}  // namespace kt
