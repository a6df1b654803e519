// How much of each cube's tetrahedra is material, and where in them.
#include <algorithm>
#include <cmath>

#include "core/base/parallel.hpp"
#include "core/body/cut_tetrahedron.hpp"
#include "io/solid/lattice_material.hpp"

namespace kt {
namespace {

/// The small tetrahedra that fill a cube's six: corners, and of which of the six.
struct SmallTetrahedron {
  std::array<int, 4> point;
  int of;
};
const std::vector<SmallTetrahedron>& small_tetrahedra() {
  static const std::vector<SmallTetrahedron> out = [] {
    std::vector<SmallTetrahedron> all;
    for (int z = 0; z < kCubePoints; ++z)
      for (int y = 0; y < kCubePoints; ++y)
        for (int x = 0; x < kCubePoints; ++x)
          for (int t = 0; t < 6; ++t) {
            SmallTetrahedron& its = all.emplace_back();
            Vec3 middle = Vec3::Zero();
            const auto steps = kuhn_corners(t);
            for (std::size_t c = 0; c < 4; ++c) {
              const std::array<int, 3> at{x + steps[c][0], y + steps[c][1], z + steps[c][2]};
              its.point[c] = point_at(at);
              middle += 0.25 / kCubePoints * Vec3(at[0], at[1], at[2]);
            }
            its.of = kuhn_holding(middle);
          }
    return all;
  }();
  return out;
}

/// Of a cube's tetrahedron, one of these.
constexpr double kSmall = 1.0 / (kCubePoints * kCubePoints * kCubePoints);

/// In coordinates of the cube.
Vec3 in_cube(int point) {
  const auto at = at_point(point);
  return Vec3(at[0], at[1], at[2]) / kCubePoints;
}
Vec3 middle_of(const std::array<int, 4>& points) {
  return 0.25 * (in_cube(points[0]) + in_cube(points[1]) + in_cube(points[2]) + in_cube(points[3]));
}
const Mat3& small_spread(int small) {
  static const std::array<Mat3, 6> all = [] {
    std::array<Mat3, 6> out;
    for (std::size_t t = 0; t < 6; ++t) {
      const std::array<int, 4>& p = small_tetrahedra()[t].point;
      out[t] = spread_of({in_cube(p[0]), in_cube(p[1]), in_cube(p[2]), in_cube(p[3])});
    }
    return out;
  }();
  return all[as_size(small % 6)];
}

}  // namespace

/// Of a small tetrahedron what is a piece's. Depths in the middles of its edges from those at their ends, and the
/// slopes there, cut its eighths by a plane each: a round surface has its volume to a higher order.
void LatticeMaterial::add_material(const CutCube& cube, int small, int piece, CellMoments& out) const {
  constexpr double kRound = 0.8;  // of the cosine between slopes: below it there is a crease
  const std::array<int, 4>& points = small_tetrahedra()[as_size(small)].point;
  std::array<double, 10> depth;
  std::array<Vec3, 4> slope;
  for (std::size_t k = 0; k < 4; ++k) {
    const std::size_t p = as_size(points[k]);
    const bool is_others = cube.depth[p] > 0 && cube.piece[p] != piece;
    depth[k] = is_others ? -cube.depth[p] : cube.depth[p];
    slope[k] = (is_others ? -cube.slope[p] : cube.slope[p]).cast<double>();
  }
  if (std::all_of(depth.begin(), depth.begin() + 4, [](double d) { return d > 0; })) {
    out.add(kSmall, middle_of(points), small_spread(small));
    return;
  }
  std::array<Vec3, 10> place;
  for (std::size_t k = 0; k < 4; ++k) place[k] = in_cube(points[k]);
  for (std::size_t e = 0; e < 6; ++e) {
    const auto a = static_cast<std::size_t>(kCellEdges[e][0]), b = static_cast<std::size_t>(kCellEdges[e][1]);
    place[4 + e] = 0.5 * (place[a] + place[b]);
    depth[4 + e] = 0.5 * (depth[a] + depth[b]);
    if (slope[a].dot(slope[b]) < kRound) continue;
    depth[4 + e] += 0.125 * (slope[a] - slope[b]).dot(step(points[a], points[b]));
  }
  CellMoments sum;
  for (const auto& eighth : kEighths) {
    const Eigen::Vector4d material = cut_tetrahedron(
        {depth[as_size(eighth[0])], depth[as_size(eighth[1])], depth[as_size(eighth[2])], depth[as_size(eighth[3])]});
    const double share = material.sum();
    if (!(share > 0)) continue;
    Vec3 middle = Vec3::Zero();
    for (std::size_t c = 0; c < 4; ++c)
      middle += material[static_cast<Eigen::Index>(c)] / share * place[as_size(eighth[c])];
    sum.add(kSmall * share / 8, middle, 0.25 * std::cbrt(share * share) * small_spread(small));
  }
  out.share += sum.share;
  out.first += sum.first;
  out.second += sum.second;
}

void LatticeMaterial::measure_by_depth(const CutCube& cube) {
  const double on_surface = kOnSurface * grid_.edge.minCoeff();
  for (int i = 0; i < static_cast<int>(small_tetrahedra().size()); ++i) {
    const SmallTetrahedron& t = small_tetrahedra()[as_size(i)];
    if (std::ranges::all_of(t.point, [&](int p) { return std::abs(cube.depth[as_size(p)]) <= on_surface; })) {
      // In an edge of the surface that fits the cubes: its middle tells.
      Vec3 middle = Vec3::Zero();
      for (const int p : t.point) middle += 0.25 * place_of(cube.cube, p);
      const int near = winding_.is_inside(middle) ? nearest_to(cube, middle) : -1;
      if (near >= 0) pieces_[as_size(near)].cell[as_size(t.of)].add(kSmall, middle_of(t.point), small_spread(i));
      continue;
    }
    std::array<int, 4> done{-1, -1, -1, -1};
    for (std::size_t c = 0; c < 4; ++c) {
      const int own = cube.piece[as_size(t.point[c])];
      if (own < 0 || std::ranges::find(done, own) != done.end()) continue;
      done[c] = own;
      add_material(cube, i, own, pieces_[as_size(own)].cell[as_size(t.of)]);
    }
  }
}

/// Depth at the point that is nearest to a place, and how far that is.
std::array<double, 2> LatticeMaterial::known_beside(const CutCube& cube, const Vec3& place) const {
  std::array<int, 3> at{};
  const Vec3 in = kCubePoints * (place - grid_.corner(grid_.place_of(cube.cube))).cwiseQuotient(grid_.edge);
  for (int k = 0; k < 3; ++k)
    at[as_size(k)] = static_cast<int>(std::clamp(std::round(in[k]), 0.0, static_cast<double>(kCubePoints)));
  const int point = point_at(at);
  return {cube.depth[as_size(point)], (place - place_of(cube.cube, point)).norm()};
}

/// Where the material is thinner than the points are apart: at many more places, each with the piece of the nearest
/// point.
void LatticeMaterial::measure_by_samples(const CutCube& cube) {
  constexpr int kSamples = 6;
  constexpr double kEach = 6.0 / (kSamples * kSamples * kSamples);
  const Vec3 corner = grid_.corner(grid_.place_of(cube.cube));
  for (int i = 0; i < kSamples * kSamples * kSamples; ++i) {
    const std::array<int, 3> at{i % kSamples, i / kSamples % kSamples, i / kSamples / kSamples};
    // Shifted against one another so that none lies on a face between two tetrahedra.
    const Vec3 in = (Vec3(at[0], at[1], at[2]) + Vec3(0.5, 0.5 + 1e-3, 0.5 - 1e-3)) / kSamples;
    const Vec3 place = corner + grid_.edge.cwiseProduct(in);
    const auto [known, away] = known_beside(cube, place);
    const bool is_clear = closes_ && std::abs(known) > away;  // the surface is further off than the point is
    if (is_clear ? known < 0 : !winding_.is_inside(place)) continue;
    int piece = nearest_to(cube, place);
    if (piece < 0) {
      if (pieces_of_cube_[as_size(cube.cube)].empty()) return;  // no vertex, and no point
      piece = pieces_of_cube_[as_size(cube.cube)][0];
    }
    pieces_[as_size(piece)].cell[as_size(kuhn_holding(in))].add(kEach, in, Mat3::Zero());
  }
}

void LatticeMaterial::measure() {
  parallel_for(static_cast<int>(cut_.size()), [&](int i) {  // pieces of different cubes are different ones
    if (cut_[as_size(i)].is_thin)
      measure_by_samples(cut_[as_size(i)]);
    else
      measure_by_depth(cut_[as_size(i)]);
    for (const int piece : pieces_of_cube_[as_size(cut_[as_size(i)].cube)])
      for (CellMoments& cell : pieces_[as_size(piece)].cell) cell.share = std::min(1.0, cell.share);
  });
}

}  // namespace kt
