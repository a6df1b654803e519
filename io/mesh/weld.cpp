#include "io/mesh/weld.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <unordered_map>
#include <vector>

#include "core/base/error.hpp"
#include "core/base/numbers.hpp"
#include "io/mesh/edge_table.hpp"

namespace kt {
namespace {

using Cell = std::array<std::int64_t, 3>;

struct CellHash {
  std::size_t operator()(const Cell& c) const {
    std::uint64_t h = 0;
    for (const std::int64_t k : c) h = (h ^ static_cast<std::uint64_t>(k)) * 0x9E3779B97F4A7C15u, h ^= h >> 29;
    return static_cast<std::size_t>(h);
  }
};

/// Points in cubes as wide as the radius of the search, so that 27 of them hold all that is near.
class PointGrid {
 public:
  PointGrid(const VectorX& x, double radius) : x_(x), radius_(radius) {}
  void add(int i) { cells_[cell(node(x_, i))].push_back(i); }

  /// Calls `see(j, squared distance)` for the points within the radius of node i; for some of them when thousands are.
  template <class See>
  void near(int i, const See& see) const {
    constexpr int kMostLooks = 10000;
    int looks = 0;
    const Vec3 p = node(x_, i);
    const Cell c = cell(p);
    for (std::int64_t a = -1; a <= 1; ++a)
      for (std::int64_t b = -1; b <= 1; ++b)
        for (std::int64_t d = -1; d <= 1; ++d) {
          const auto found = cells_.find({c[0] + a, c[1] + b, c[2] + d});
          if (found == cells_.end()) continue;
          for (const int j : found->second) {
            if (++looks > kMostLooks) return;
            if (const double distance_sq = (node(x_, j) - p).squaredNorm(); distance_sq <= radius_ * radius_)
              see(j, distance_sq);
          }
        }
  }

 private:
  /// Far cells share the last number: they are searched together, and found by distance.
  Cell cell(const Vec3& p) const {
    constexpr double kMost = 4e18;  // below the range of the numbers of cells
    Cell c{};
    for (int k = 0; k < 3; ++k) c[k] = static_cast<std::int64_t>(std::clamp(std::floor(p[k] / radius_), -kMost, kMost));
    return c;
  }

  const VectorX& x_;
  double radius_;
  std::unordered_map<Cell, std::vector<int>, CellHash> cells_;
};

/// The node that stands for each: the first one in the same place.
std::vector<int> equal_nodes(const VectorX& x, int n) {
  std::vector<int> order, stands(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) {
    stands[i] = i;
    if (node(x, i).allFinite()) order.push_back(i);
  }
  const auto compare = [&](int a, int b) {
    for (int k = 0; k < 3; ++k)
      if (x[3 * a + k] != x[3 * b + k]) return x[3 * a + k] < x[3 * b + k];
    return a < b;
  };
  std::sort(order.begin(), order.end(), compare);
  for (std::size_t i = 1; i < order.size(); ++i)
    if (node(x, order[i]) == node(x, order[i - 1])) stands[order[i]] = stands[order[i - 1]];
  return stands;
}

/// In order of their numbers; a node that another stands for stands for none.
void join_near(const VectorX& x, double tolerance, std::vector<int>& stands) {
  PointGrid grid(x, tolerance);
  for (int i = 0; i < static_cast<int>(stands.size()); ++i) {
    if (stands[i] != i) {
      stands[i] = stands[stands[i]];
      continue;
    }
    if (!node(x, i).allFinite()) continue;
    int first = i;
    grid.near(i, [&](int j, double) { first = std::min(first, j); });
    stands[i] = first;
    if (first == i) grid.add(i);
  }
}

/// Nodes of open edges, and the mean length of these.
std::vector<int> border_nodes(const Mesh& mesh, const EdgeTable& table, double& mean_length) {
  std::vector<int> out;
  double sum = 0;
  int edges = 0;
  for (const Edge& e : table.edges) {
    const double length = (node(mesh.x, e.a) - node(mesh.x, e.b)).norm();
    if (e.count != 1 || !std::isfinite(length)) continue;
    out.insert(out.end(), {e.a, e.b});
    sum += length;
    ++edges;
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  mean_length = edges > 0 ? sum / edges : 0;
  return out;
}

int count_open_edges(const EdgeTable& table) {
  return static_cast<int>(
      std::count_if(table.edges.begin(), table.edges.end(), [](const Edge& e) { return e.count == 1; }));
}

double rounded_up_to_one_digit(double value) {
  const double unit = std::pow(10, std::floor(std::log10(value)));
  return *to_double(text(std::ceil(value / unit * (1 - 1e-12)) * unit));
}

}  // namespace

double rounding_of(const Mesh& mesh) {
  double largest = 0;
  for (const double value : mesh.x)
    if (std::isfinite(value)) largest = std::max(largest, std::abs(value));
  return 4 * std::numeric_limits<double>::epsilon() * largest;
}

int join_nodes(Mesh& mesh, double tolerance) {
  std::vector<int> stands = equal_nodes(mesh.x, mesh.num_nodes());
  if (tolerance > 0) join_near(mesh.x, tolerance, stands);
  int joined = 0;
  for (int i = 0; i < mesh.num_nodes(); ++i) joined += stands[i] != i;
  for (Triangle& t : mesh.triangles)
    for (int& i : t) i = stands[i];
  for (Tetrahedron& t : mesh.tetrahedra)
    for (int& i : t) i = stands[i];
  return joined;
}

std::optional<NearNodes> find_near_nodes(const Mesh& surface) {
  const EdgeTable table = make_edge_table(surface.triangles);
  double mean_length = 0;
  const std::vector<int> border = border_nodes(surface, table, mean_length);
  constexpr double kNear = 0.1;  // of an edge; farther apart they are a gap, which is for --fill-holes
  if (border.empty() || !(mean_length > 0)) return std::nullopt;
  PointGrid grid(surface.x, kNear * mean_length);
  for (const int i : border) grid.add(i);
  NearNodes out;
  double largest_sq = 0;
  for (const int i : border) {
    double nearest_sq = std::numeric_limits<double>::infinity();
    grid.near(i, [&](int j, double distance_sq) {
      if (distance_sq > 0 && j != i) nearest_sq = std::min(nearest_sq, distance_sq);
    });
    if (std::isfinite(nearest_sq)) largest_sq = std::max(largest_sq, nearest_sq);
  }
  out.distance = std::sqrt(largest_sq);
  if (!(out.distance > rounding_of(surface))) return std::nullopt;
  out.tolerance = rounded_up_to_one_digit(2 * out.distance);
  Mesh joined = surface;
  out.count = join_nodes(joined, out.tolerance);
  std::erase_if(joined.triangles, repeats_node);
  out.open_edges_before = count_open_edges(table);
  out.open_edges_after = count_open_edges(make_edge_table(joined.triangles));
  if (out.open_edges_after >= out.open_edges_before) return std::nullopt;
  return out;
}

}  // namespace kt
