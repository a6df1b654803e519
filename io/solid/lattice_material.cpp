#include "io/solid/lattice_material.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/parallel.hpp"

namespace kt {
namespace {

/// Sets that grow together.
int root_of(std::vector<int>& same, int i) {
  while (same[as_size(i)] != i) i = same[as_size(i)] = same[as_size(same[as_size(i)])];
  return i;
}
void unite(std::vector<int>& same, int a, int b) {
  a = root_of(same, a);
  b = root_of(same, b);
  same[as_size(std::max(a, b))] = std::min(a, b);
}
std::vector<int> each_alone(std::size_t count) {
  std::vector<int> out(count);
  std::iota(out.begin(), out.end(), 0);
  return out;
}

template <class Work>
void for_batches(std::size_t count, const Work& work) {
  constexpr std::size_t kBatch = 64;
  parallel_for(static_cast<int>(count / kBatch) + 1, [&](int batch) {
    const std::size_t begin = as_size(batch) * kBatch, end = std::min(count, begin + kBatch);
    for (std::size_t i = begin; i < end; ++i) work(i);
  });
}

/// The other corner of a cube of points from its lowest one along edges, diagonals of faces and its own.
constexpr std::array<std::array<int, 3>, 7> kKuhnSteps{
    {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}}};

}  // namespace

LatticeMaterial::LatticeMaterial(Mesh surface, bool closes)
    : surface_(std::move(surface)), winding_(surface_), closes_(closes) {}

Vec3 LatticeMaterial::place_of(int cube, int point) const {
  const auto at = at_point(point);
  return grid_.corner(grid_.place_of(cube)) + grid_.edge.cwiseProduct(Vec3(at[0], at[1], at[2])) / kCubePoints;
}

Vec3 LatticeMaterial::step(int from, int to) const {
  const auto a = at_point(from), b = at_point(to);
  return grid_.edge.cwiseProduct(Vec3(b[0] - a[0], b[1] - a[1], b[2] - a[2])) / kCubePoints;
}

int LatticeMaterial::new_piece(int cube) {
  const int number = static_cast<int>(pieces_.size());
  pieces_.push_back({cube, {}});
  pieces_of_cube_[as_size(cube)].push_back(number);
  return number;
}

// ---- depths ----

void LatticeMaterial::cut(const LatticeGrid& grid) {
  grid_ = grid;
  cap_ = 1.01 * grid.edge.norm() / kCubePoints;
  const std::vector<char> touched = touched_cubes(grid, surface_);
  cut_of_cube_.assign(touched.size(), -1);
  cut_.clear();
  pieces_.clear();
  pieces_of_cube_.assign(touched.size(), {});
  is_full_ = full_cubes(grid, touched);
  for (int cube = 0; cube < grid.num_cubes(); ++cube) {
    if (is_full_[as_size(cube)]) {
      CubePiece& whole = pieces_[as_size(new_piece(cube))];
      for (int t = 0; t < 6; ++t) whole.cell[as_size(t)] = whole_cell(t);
    }
    if (!touched[as_size(cube)]) continue;
    cut_of_cube_[as_size(cube)] = static_cast<int>(cut_.size());
    cut_.emplace_back().cube = cube;
  }
  find_depths();
  find_pieces();
}

std::vector<char> LatticeMaterial::full_cubes(const LatticeGrid& grid, const std::vector<char>& touched) const {
  std::vector<int> same = each_alone(touched.size());
  for (int cube = 0; closes_ && cube < grid.num_cubes(); ++cube) {
    if (touched[as_size(cube)]) continue;
    const auto at = grid.place_of(cube);
    for (std::size_t c = 0; c < 3; ++c) {
      auto next = at;
      if (++next[c] < grid.count[c] && !touched[as_size(grid.cube(next))]) unite(same, cube, grid.cube(next));
    }
  }
  std::vector<char> out(touched.size(), 0);
  parallel_for(grid.num_cubes(), [&](int cube) {
    if (!touched[as_size(cube)] && same[as_size(cube)] == cube)
      out[as_size(cube)] = winding_.is_inside(grid.middle(cube));
  });
  for (int cube = 0; cube < grid.num_cubes(); ++cube) out[as_size(cube)] = out[as_size(root_of(same, cube))];
  return out;
}

/// Points that cubes share are looked at once.
void LatticeMaterial::find_depths() {
  const std::array<long, 3> count{kCubePoints * long{grid_.count[0]} + 1, kCubePoints * long{grid_.count[1]} + 1,
                                  kCubePoints * long{grid_.count[2]} + 1};
  std::vector<long> points;
  const auto number = [&](int cube, int point) {
    const auto at = grid_.place_of(cube), in = at_point(point);
    return kCubePoints * at[0] + in[0] +
           count[0] * (kCubePoints * at[1] + in[1] + count[1] * (long{kCubePoints} * at[2] + in[2]));
  };
  for (const CutCube& c : cut_)
    for (int p = 0; p < kAllPoints; ++p) points.push_back(number(c.cube, p));
  std::ranges::sort(points);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  const std::array<long, 3> step{1, count[0], count[0] * count[1]};
  const auto index_of = [&](long n) {
    const auto found = std::ranges::lower_bound(points, n);
    return found != points.end() && *found == n ? static_cast<int>(found - points.begin()) : -1;
  };
  /// Beside a point; -1: there is none, or it is of no interest.
  const auto beside = [&](std::size_t i, std::size_t axis, int steps) {
    const long n = points[i], there = n / step[axis] % count[axis] + steps;
    return there < 0 || there >= count[axis] ? -1 : index_of(n + steps * step[axis]);
  };
  std::vector<float> depth(points.size());
  std::vector<Eigen::Vector3f> slope(points.size(), Eigen::Vector3f::Zero());
  const double on_surface = kOnSurface * grid_.edge.minCoeff();
  const auto place_of_point = [&](std::size_t i) -> Vec3 {
    const long n = points[i];
    const Vec3 at(static_cast<double>(n % count[0]), static_cast<double>(n / count[0] % count[1]),
                  static_cast<double>(n / count[0] / count[1]));
    return grid_.origin + grid_.edge.cwiseProduct(at) / kCubePoints;
  };
  for_batches(points.size(), [&](std::size_t i) {
    const Vec3 place = place_of_point(i);
    const std::optional<Vec3> nearest = winding_.nearest(place, cap_);
    const double distance = nearest ? (place - *nearest).norm() : cap_;
    depth[i] = static_cast<float>(distance);
    if (nearest && distance > on_surface) slope[i] = ((place - *nearest) / distance).cast<float>();
  });
  // A point lies on the same side as its neighbours that are nearer to it than the surface is.
  std::vector<int> same = each_alone(points.size());
  for (std::size_t i = 0; closes_ && i < points.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) {
      const int next = beside(i, c, 1);
      const double away = (1 + 1e-3) * grid_.edge[static_cast<Eigen::Index>(c)] / kCubePoints;
      if (next >= 0 && std::max(depth[i], depth[as_size(next)]) > away) unite(same, static_cast<int>(i), next);
    }
  std::vector<char> is_in(points.size(), 0), is_unsure(points.size(), 0);
  for_batches(points.size(), [&](std::size_t i) {
    if (same[i] != static_cast<int>(i)) return;
    const double turns = std::abs(winding_.at(place_of_point(i)));
    is_in[i] = turns > 0.5;
    is_unsure[i] = turns > 0.25 && turns < 0.75;
  });
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t its = as_size(root_of(same, static_cast<int>(i)));
    is_unsure[i] = is_unsure[its];
    if (is_in[its]) continue;
    depth[i] = -depth[i];
    slope[i] = -slope[i];
  }
  // Inside, with outside on both sides.
  const auto is_outside = [&](int i) { return i >= 0 && !(depth[as_size(i)] > 0); };
  std::vector<char> is_thin(points.size(), 0);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (depth[i] > 0)
      for (std::size_t c = 0; c < 3; ++c) is_thin[i] |= is_outside(beside(i, c, -1)) && is_outside(beside(i, c, 1));
  for (CutCube& c : cut_)
    for (int p = 0; p < kAllPoints; ++p) {
      const std::size_t at = as_size(index_of(number(c.cube, p)));
      c.depth[as_size(p)] = depth[at];
      c.slope[as_size(p)] = slope[at];
      c.is_thin |= is_thin[at] != 0;
    }
  unsure_ = std::ranges::count(is_unsure, 1);
  inside_ = std::ranges::count_if(depth, [](float d) { return d > 0; });
}

double LatticeMaterial::unsure() const {
  return static_cast<double>(unsure_) / static_cast<double>(std::max(1L, inside_));
}

// ---- pieces ----

/// Of each point the lowest one that it hangs together with. The ways between them lie a little inside of the cube:
/// what hangs together in its neighbour alone is no piece here.
std::vector<int> LatticeMaterial::connect(const CutCube& cube) const {
  constexpr double kInside = 2e-3;  // of the way to its middle
  const Vec3 middle = grid_.middle(cube.cube);
  std::vector<int> same = each_alone(kAllPoints);
  for (int p = 0; p < kAllPoints; ++p) {
    if (!(cube.depth[as_size(p)] > 0)) continue;
    const auto at = at_point(p);
    for (const auto& step : kKuhnSteps) {
      const std::array<int, 3> other{at[0] + step[0], at[1] + step[1], at[2] + step[2]};
      if (std::ranges::max(other) >= kWide) continue;
      const int q = point_at(other);
      if (!(cube.depth[as_size(q)] > 0) || root_of(same, p) == root_of(same, q)) continue;
      Vec3 from = place_of(cube.cube, p), to = place_of(cube.cube, q);
      from += kInside * (middle - from);
      to += kInside * (middle - to);
      const double moved = 2 * kInside * grid_.edge.norm();
      const bool may_part = cube.depth[as_size(p)] + cube.depth[as_size(q)] <= (to - from).norm() + moved;
      if (!may_part || !winding_.parts(from, to)) unite(same, p, q);
    }
  }
  for (int p = 0; p < kAllPoints; ++p) same[as_size(p)] = root_of(same, p);
  return same;
}

void LatticeMaterial::find_pieces() {
  parallel_for(static_cast<int>(cut_.size()), [&](int i) {
    CutCube& c = cut_[as_size(i)];
    const std::vector<int> same = connect(c);
    bool has_any = false;
    for (int p = 0; p < kAllPoints; ++p) {
      const bool is_in = c.depth[as_size(p)] > 0;
      c.piece[as_size(p)] = is_in ? same[as_size(p)] : -1;
      has_any |= is_in;
    }
    c.is_thin |= !has_any;
  });
  for (CutCube& c : cut_) {
    std::array<int, kAllPoints> number;
    number.fill(-1);
    for (int& piece : c.piece) {
      if (piece < 0) continue;
      int& n = number[as_size(piece)];
      if (n < 0) n = new_piece(c.cube);
      piece = n;
    }
  }
}

int LatticeMaterial::nearest_to(const CutCube& cube, const Vec3& place) const {
  int out = -1;
  double best = std::numeric_limits<double>::infinity();
  for (int p = 0; p < kAllPoints; ++p) {
    if (cube.piece[as_size(p)] < 0) continue;
    const double away = (place_of(cube.cube, p) - place).squaredNorm();
    if (away < best) {
      best = away;
      out = cube.piece[as_size(p)];
    }
  }
  return out;
}

/// The piece of the nearest point that nothing lies before; -1: none of the nearest.
int LatticeMaterial::seen_from(const CutCube& cube, const Vec3& place) const {
  constexpr int kAsked = 12;
  std::vector<std::pair<double, int>> points;
  for (int p = 0; p < kAllPoints; ++p)
    if (cube.piece[as_size(p)] >= 0) points.emplace_back((place_of(cube.cube, p) - place).squaredNorm(), p);
  std::ranges::sort(points);
  for (std::size_t i = 0; i < points.size() && i < kAsked; ++i)
    if (!winding_.parts(place, place_of(cube.cube, points[i].second))) return cube.piece[as_size(points[i].second)];
  return -1;
}

/// Some vertices of a patch look for the pieces below them; the others go with the last one that was seen, and where
/// none was, with the nearest one.
void LatticeMaterial::look_below(const CutCube& cube, const std::vector<int>& vertices, const std::vector<Vec3>& below,
                                 std::vector<int>& piece, std::vector<char>& is_sure) const {
  constexpr std::size_t kAsked = 16;
  int seen = -1;
  std::vector<int> own(vertices.size(), -1);
  const std::size_t asked = std::min(kAsked, vertices.size());
  for (std::size_t i = 0; i < asked; ++i) {
    const std::size_t k = i * vertices.size() / asked;
    const Vec3& place = below[as_size(vertices[k])];
    own[k] = winding_.is_inside(place) ? seen_from(cube, place) : -1;
    if (own[k] >= 0) seen = own[k];
  }
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    const int its = own[k] >= 0 ? own[k] : seen >= 0 ? seen : nearest_to(cube, below[as_size(vertices[k])]);
    is_sure[as_size(vertices[k])] = seen >= 0;
    if (its >= 0) piece[as_size(vertices[k])] = its;
  }
}

std::vector<int> LatticeMaterial::hold(const std::vector<Vec3>& below, const std::vector<Triangle>& triangles) {
  std::vector<int> cube(below.size());
  for (std::size_t v = 0; v < below.size(); ++v) cube[v] = grid_.cube(grid_.holding(below[v]));
  // Patches of the surface in cubes.
  std::vector<int> patch = each_alone(below.size());
  const auto for_edges = [&](const auto& give) {
    for (const Triangle& t : triangles)
      for (std::size_t c = 0; c < 3; ++c) give(t[c], t[(c + 1) % 3]);
  };
  for_edges([&](int a, int b) {
    if (cube[as_size(a)] == cube[as_size(b)]) unite(patch, a, b);
  });
  std::vector<std::vector<int>> of_patch(below.size());
  std::vector<int> patches;
  std::vector<int> patches_in(pieces_of_cube_.size(), 0);
  for (int v = 0; v < static_cast<int>(below.size()); ++v) {
    std::vector<int>& its = of_patch[as_size(root_of(patch, v))];
    if (its.empty()) {
      patches.push_back(root_of(patch, v));
      ++patches_in[as_size(cube[as_size(v)])];
    }
    its.push_back(v);
  }
  std::vector<int> out(below.size(), -1);
  std::vector<char> is_sure(below.size(), 1);
  for (const int p : patches)
    if (pieces_of_cube_[as_size(cube[as_size(p)])].empty()) new_piece(cube[as_size(p)]);
  parallel_for(static_cast<int>(patches.size()), [&](int i) {
    const std::vector<int>& vertices = of_patch[as_size(patches[as_size(i)])];
    const int its_cube = cube[as_size(vertices[0])], cut = cut_of(its_cube);
    const std::vector<int>& pieces = pieces_of_cube_[as_size(its_cube)];
    for (const int v : vertices) out[as_size(v)] = pieces[0];
    if (cut < 0 || (pieces.size() == 1 && patches_in[as_size(its_cube)] == 1)) return;
    look_below(cut_[as_size(cut)], vertices, below, out, is_sure);
  });
  // What the surface goes along hangs together below it.
  std::vector<int> same = each_alone(pieces_.size());
  for_edges([&](int a, int b) {
    if (!is_sure[as_size(a)] || !is_sure[as_size(b)]) return;
    if (cube[as_size(a)] == cube[as_size(b)])
      unite(same, out[as_size(a)], out[as_size(b)]);
    else
      seams_.push_back({out[as_size(a)], out[as_size(b)]});
  });
  std::vector<int> number(pieces_.size(), -1);
  std::vector<CubePiece> kept;
  for (auto& pieces : pieces_of_cube_) pieces.clear();
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const int first = root_of(same, static_cast<int>(i));
    if (number[as_size(first)] < 0) {
      number[as_size(first)] = static_cast<int>(kept.size());
      pieces_of_cube_[as_size(pieces_[i].cube)].push_back(number[as_size(first)]);
      kept.push_back(pieces_[i]);
    }
    number[i] = number[as_size(first)];
  }
  pieces_ = std::move(kept);
  for (int& piece : out) piece = number[as_size(piece)];
  for (auto& [a, b] : seams_) a = number[as_size(a)], b = number[as_size(b)];
  std::ranges::sort(seams_);
  seams_.erase(std::unique(seams_.begin(), seams_.end()), seams_.end());
  for (CutCube& c : cut_)
    for (int& piece : c.piece)
      if (piece >= 0) piece = number[as_size(piece)];
  return out;
}

int LatticeMaterial::parted_cubes() const {
  return static_cast<int>(std::ranges::count_if(pieces_of_cube_, [](const auto& p) { return p.size() > 1; }));
}

// ---- which corners are one ----

/// Pieces of neighbouring cubes with a point that both have: their common corners are one.
template <class Take>
void for_shared_points(const std::array<int, 3>& to, const Take& give) {
  const auto low = [&](std::size_t c) { return to[c] > 0 ? kCubePoints : 0; };
  const auto high = [&](std::size_t c) { return to[c] < 0 ? 0 : kCubePoints; };
  for (int z = low(2); z <= high(2); ++z)
    for (int y = low(1); y <= high(1); ++y)
      for (int x = low(0); x <= high(0); ++x)
        give(point_at({x, y, z}),
             point_at({x - kCubePoints * to[0], y - kCubePoints * to[1], z - kCubePoints * to[2]}));
}

void join_common_corners(std::vector<int>& same, int a, int b, const std::array<int, 3>& to) {
  for (int corner = 0; corner < 8; ++corner) {
    int other = 0;
    bool is_common = true;
    for (int c = 0; c < 3; ++c) {
      const int at = corner >> c & 1, of_other = at - to[as_size(c)];
      is_common = is_common && (of_other == 0 || of_other == 1);
      other |= (of_other & 1) << c;
    }
    if (is_common) unite(same, 8 * a + corner, 8 * b + other);
  }
}

void LatticeMaterial::join_by_points(std::vector<int>& same) const {
  for (int cube = 0; cube < grid_.num_cubes(); ++cube) {
    if (pieces_of_cube_[as_size(cube)].empty()) continue;
    const auto at = grid_.place_of(cube);
    for (int direction = 14; direction < 27; ++direction) {  // each pair of neighbours once
      const std::array<int, 3> to{direction % 3 - 1, direction / 3 % 3 - 1, direction / 9 - 1};
      const std::array<int, 3> next{at[0] + to[0], at[1] + to[1], at[2] + to[2]};
      if (next[0] < 0 || next[1] < 0 || next[2] < 0 || next[0] >= grid_.count[0] || next[1] >= grid_.count[1] ||
          next[2] >= grid_.count[2])
        continue;
      const int other = grid_.cube(next);
      if (pieces_of_cube_[as_size(other)].empty()) continue;
      const int own_cut = cut_of(cube), other_cut = cut_of(other);
      for_shared_points(to, [&](int p, int q) {
        const int a = own_cut < 0 ? pieces_of_cube_[as_size(cube)][0] : cut_[as_size(own_cut)].piece[as_size(p)];
        const int b = other_cut < 0 ? pieces_of_cube_[as_size(other)][0] : cut_[as_size(other_cut)].piece[as_size(q)];
        if (a >= 0 && b >= 0) join_common_corners(same, a, b, to);
      });
    }
  }
}

std::vector<int> LatticeMaterial::join_corners() {
  std::vector<int> same = each_alone(8 * pieces_.size());
  join_by_points(same);
  for (const auto& [a, b] : seams_) {
    const auto from = grid_.place_of(pieces_[as_size(a)].cube), next = grid_.place_of(pieces_[as_size(b)].cube);
    join_common_corners(same, a, b, {next[0] - from[0], next[1] - from[1], next[2] - from[2]});
  }
  for (std::size_t i = 0; i < same.size(); ++i) same[i] = root_of(same, static_cast<int>(i));
  return same;
}

// ---- of cells ----

bool LatticeMaterial::is_whole(int cell) const {
  return is_full_[as_size(pieces_[as_size(piece_of_cell_[as_size(cell)])].cube)] != 0;
}

double LatticeMaterial::depth(int cell, const Vec3& place, double most) const {
  const int own = piece_of_cell_[as_size(cell)], cube = pieces_[as_size(own)].cube;
  if (cut_of(cube) < 0) return is_full_[as_size(cube)] ? most : -most;
  const CutCube& c = cut_[as_size(cut_of(cube))];
  std::array<int, 3> at{};
  const Vec3 in = kCubePoints * (place - grid_.corner(grid_.place_of(cube))).cwiseQuotient(grid_.edge);
  for (int k = 0; k < 3; ++k)
    at[as_size(k)] = static_cast<int>(std::clamp(std::round(in[k]), 0.0, static_cast<double>(kCubePoints)));
  const int point = point_at(at);
  const double known = c.depth[as_size(point)];
  const double clear = std::abs(known) - (place - place_of(cube, point)).norm();  // nothing is as near
  const bool is_inside = clear > 0 ? known > 0 : winding_.is_inside(place);
  // Depths at points are in single precision: a place is as far away as `most` by more than their rounding.
  const double distance = clear >= (1 + 1e-6) * most ? most : winding_.distance(place, most);
  if (!is_inside) return -distance;
  if (pieces_of_cube_[as_size(cube)].size() < 2) return distance;
  int piece = clear > 0 ? c.piece[as_size(point)] : seen_from(c, place);
  if (piece < 0) piece = nearest_to(c, place);
  return piece == own ? distance : -distance;
}

}  // namespace kt
