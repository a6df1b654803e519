#include "io/solid/lattice_surface.hpp"

#include <cmath>
#include <cstdint>

#include "core/body/pieces.hpp"
#include "io/mesh/weld.hpp"

namespace kt {
namespace {

void look_at_edges(const Mesh& surface, LatticeReport& report) {
  std::vector<std::uint64_t> edges;  // lower end, upper end, and whether it is passed downwards
  edges.reserve(3 * surface.triangles.size());
  for (const Triangle& t : surface.triangles)
    for (std::size_t c = 0; c < 3; ++c) {
      const auto a = static_cast<std::uint64_t>(t[c]), b = static_cast<std::uint64_t>(t[(c + 1) % 3]);
      edges.push_back(std::min(a, b) << 32 | std::max(a, b) << 1 | (a > b));
    }
  std::ranges::sort(edges);
  report.closes = true;
  for (std::size_t i = 0, end = 0; i < edges.size(); i = end) {
    std::size_t down = 0;
    for (; end < edges.size() && edges[end] >> 1 == edges[i] >> 1; ++end) down += edges[end] & 1;
    report.open_edges += end - i == 1;
    report.closes = report.closes && 2 * down == end - i;
  }
}

}  // namespace

Mesh clean_surface(const Mesh& surface, LatticeReport& report) {
  constexpr double kNoArea = 1e-16;  // of the size squared: rounding
  Mesh joined{surface.x, surface.triangles, {}};
  join_nodes(joined, 0);
  Mesh out;
  std::vector<int> number(static_cast<std::size_t>(joined.num_nodes()), -1);
  std::vector<Vec3> places;
  const double size = bounds(surface).size().norm();
  for (const Triangle& t : joined.triangles) {
    const Vec3 a = node(joined.x, t[0]), ab = node(joined.x, t[1]) - a, ac = node(joined.x, t[2]) - a;
    if (!(ab.cross(ac).norm() > kNoArea * size * size)) {
      ++report.degenerate;
      continue;
    }
    Triangle own{};
    for (std::size_t c = 0; c < 3; ++c) {
      int& n = number[static_cast<std::size_t>(t[c])];
      if (n < 0) {
        n = static_cast<int>(places.size());
        places.emplace_back(node(joined.x, t[c]));
      }
      own[c] = n;
    }
    out.triangles.push_back(own);
  }
  out.x.resize(3 * static_cast<Eigen::Index>(places.size()));
  for (std::size_t i = 0; i < places.size(); ++i) node(out.x, static_cast<int>(i)) = places[i];
  look_at_edges(out, report);
  return out;
}

namespace {

/// New nodes in the middles of edges that are too long.
class Halver {
 public:
  Halver(const Mesh& mesh, double longest) : mesh_(mesh), longest_sq_(longest * longest) {
    for (const Triangle& t : mesh.triangles)
      for (std::size_t c = 0; c < 3; ++c) {
        const int a = t[c], b = t[(c + 1) % 3];
        if ((node(mesh.x, a) - node(mesh.x, b)).squaredNorm() > longest_sq_)
          edges_.push_back({std::min(a, b), std::max(a, b)});
      }
    std::ranges::sort(edges_);
    edges_.erase(std::unique(edges_.begin(), edges_.end()), edges_.end());
  }
  const std::vector<std::array<int, 2>>& edges() const { return edges_; }

  /// The pieces of a triangle; corners of two are the middles of edges.
  template <class Give>
  void cut(const Triangle& t, const Give& give) const {
    const std::array<int, 3> mid{between(t[0], t[1]), between(t[1], t[2]), between(t[2], t[0])};
    const auto halved = std::ranges::count_if(mid, [](int i) { return i >= 0; });
    if (halved == 0) return give(t);
    if (halved == 3) {
      for (std::size_t c = 0; c < 3; ++c) give({t[c], mid[c], mid[(c + 2) % 3]});
      return give({mid[0], mid[1], mid[2]});
    }
    for (std::size_t e = 0; e < 3; ++e) {  // an edge that is halved, after one that is not
      if (mid[e] < 0 || mid[(e + 2) % 3] >= 0) continue;
      const int a = t[e], b = t[(e + 1) % 3], c = t[(e + 2) % 3], ab = mid[e], bc = mid[(e + 1) % 3];
      give({a, ab, c});
      if (bc < 0) return give({ab, b, c});
      give({ab, b, bc});
      return give({ab, bc, c});
    }
  }

 private:
  int between(int a, int b) const {
    const std::array<int, 2> edge{std::min(a, b), std::max(a, b)};
    const auto found = std::ranges::lower_bound(edges_, edge);
    if (found == edges_.end() || *found != edge) return -1;
    return mesh_.num_nodes() + static_cast<int>(found - edges_.begin());
  }
  const Mesh& mesh_;
  double longest_sq_;
  std::vector<std::array<int, 2>> edges_;
};

}  // namespace

Mesh with_short_edges(Mesh surface, double longest) {
  for (;;) {
    const Halver halver(surface, longest);
    if (halver.edges().empty()) return surface;
    Mesh next;
    for (const Triangle& t : surface.triangles)
      halver.cut(t, [&](const Triangle& piece) { next.triangles.push_back(piece); });
    next.x.resize(surface.x.size() + 3 * static_cast<Eigen::Index>(halver.edges().size()));
    next.x.head(surface.x.size()) = surface.x;
    int i = surface.num_nodes();
    for (const auto& [a, b] : halver.edges()) node(next.x, i++) = 0.5 * (node(surface.x, a) + node(surface.x, b));
    surface = std::move(next);
  }
}

std::optional<Mesh> turn_outward(const Mesh& surface, const WindingNumber& winding, LatticeReport& report) {
  constexpr std::size_t kAsked = 16;  // triangles of a piece
  constexpr double kOff = 0.05;       // of the root of a triangle's area: to either side
  std::optional<Mesh> out;
  int count = 0;
  const std::vector<int> piece = pieces_of(surface, count);
  std::vector<std::vector<std::size_t>> of_piece(static_cast<std::size_t>(count));
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    of_piece[static_cast<std::size_t>(piece[static_cast<std::size_t>(surface.triangles[t][0])])].push_back(t);
  for (const std::vector<std::size_t>& triangles : of_piece) {
    double inward = 0;  // area
    const std::size_t asked = std::min(kAsked, triangles.size());
    for (std::size_t i = 0; i < asked; ++i) {
      const Triangle& t = surface.triangles[triangles[i * triangles.size() / asked]];
      const Vec3 a = node(surface.x, t[0]), b = node(surface.x, t[1]), c = node(surface.x, t[2]);
      const Vec3 area = 0.5 * (b - a).cross(c - a), middle = (a + b + c) / 3;
      const Vec3 off = kOff / std::sqrt(area.norm()) * area;
      const bool above = winding.is_inside(middle + off), below = winding.is_inside(middle - off);
      if (above != below) inward += above ? area.norm() : -area.norm();
    }
    if (!(inward > 0)) continue;
    if (!out) out = surface;
    for (const std::size_t t : triangles) std::swap(out->triangles[t][1], out->triangles[t][2]);
    report.turned += static_cast<int>(triangles.size());
  }
  return out;
}

}  // namespace kt
