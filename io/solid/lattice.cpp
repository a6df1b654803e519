#include "io/solid/lattice.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/error.hpp"
#include "core/base/finding.hpp"
#include "core/base/numbers.hpp"
#include "core/body/cut_tetrahedron.hpp"
#include "core/body/embedded_surface.hpp"
#include "io/solid/lattice_grid.hpp"
#include "io/solid/lattice_material.hpp"
#include "io/solid/lattice_surface.hpp"

namespace kt {
namespace {

constexpr double kThick = 6;          // edges: four-node cells bend as they should
constexpr double kLeastShare = 1e-3;  // of a tetrahedron that holds a vertex: it must not move freely

// ---- how large the cubes are ----

LatticeGrid make_grid(const Bounds& box, double edge, const LatticeOptions& options) {
  return make_lattice_grid(box, edge, options.clamped ? std::optional(options.clamped(box)) : std::nullopt);
}

/// Nodes of cubes that are touched, or have their middle inside.
/// @param steps  between them along an edge of a cube: one, or two with the middles of edges
int count_nodes(const LatticeGrid& grid, const LatticeMaterial& material, int steps) {
  const std::vector<char> touched = touched_cubes(grid, material.surface());
  const std::vector<char> full = material.full_cubes(grid, touched);
  LatticeGrid nodes = grid;
  for (int& count : nodes.count) count *= steps;
  std::vector<char> is_node(static_cast<std::size_t>(nodes.num_nodes()), 0);
  for (int cube = 0; cube < grid.num_cubes(); ++cube) {
    if (!touched[static_cast<std::size_t>(cube)] && !full[static_cast<std::size_t>(cube)]) continue;
    const auto [x, y, z] = grid.place_of(cube);
    for (int k = 0; k <= steps; ++k)
      for (int j = 0; j <= steps; ++j)
        for (int i = 0; i <= steps; ++i)
          is_node[static_cast<std::size_t>(nodes.node({steps * x + i, steps * y + j, steps * z + k}))] = 1;
  }
  return static_cast<int>(std::ranges::count(is_node, 1));
}

/// The largest edge with about as many nodes as are wanted.
double find_edge(const Bounds& box, const LatticeMaterial& material, const LatticeOptions& options, int nodes) {
  constexpr int kTries = 12;
  constexpr double kFinest = 1e-2;  // of the longest extent: a million cubes at most
  double high = box.size().maxCoeff(), low = kFinest * high;
  for (int i = 0; i < kTries; ++i) {
    const double middle = std::sqrt(low * high);
    const LatticeGrid grid = make_grid(box, middle, options);
    (count_nodes(grid, material, options.is_quadratic ? 2 : 1) > nodes ? low : high) = middle;
  }
  return high;
}

/// Median of the ways through the material from the surface inward, of triangles by their area.
/// @param most  ways are no longer than that
double find_thickness(const WindingNumber& winding, const Mesh& surface, double most) {
  constexpr int kAsked = 255;
  constexpr double kOff = 1e-6;  // of the way: the triangle that it begins at
  std::vector<Vec3> area;
  double all = 0;
  for (const Triangle& t : surface.triangles) {
    const Vec3 a = node(surface.x, t[0]);
    area.emplace_back(0.5 * (node(surface.x, t[1]) - a).cross(node(surface.x, t[2]) - a));
    all += area.back().norm();
  }
  std::vector<double> ways;
  double sum = 0;
  for (std::size_t t = 0; t < area.size(); ++t) {
    sum += area[t].norm();
    const Triangle& v = surface.triangles[t];
    const Vec3 middle = (node(surface.x, v[0]) + node(surface.x, v[1]) + node(surface.x, v[2])) / 3;
    const Vec3 end = middle - most * area[t].normalized(), begin = middle + kOff * (end - middle);
    double way = 0;
    for (bool is_known = false; sum > (static_cast<double>(ways.size()) + 0.5) / kAsked * all; is_known = true) {
      if (!is_known) way = most * winding.first_crossing(begin, end).value_or(1);
      ways.push_back(way);
    }
  }
  if (ways.empty()) return most;
  const auto half = ways.begin() + static_cast<std::ptrdiff_t>(ways.size() / 2);
  std::ranges::nth_element(ways, half);
  return *half;
}

// ---- the lattice ----

class LatticeMaker {
 public:
  /// @param surface  the material's, with short edges
  LatticeMaker(const LatticeGrid& grid, const Mesh& surface, LatticeMaterial& material, bool is_quadratic)
      : grid_(grid),
        surface_(surface),
        material_(material),
        is_quadratic_(is_quadratic),
        embedded_(std::make_shared<EmbeddedSurface>()) {
    material_.cut(grid);
    const std::vector<Vec3> below = places_below();
    piece_ = material_.hold(below, surface.triangles);
    material_.measure();
    corner_ = material_.join_corners();
    for (const CubePiece& piece : material_.pieces())
      for (std::size_t t = 0; t < 6; ++t) (t == 0 ? share_.emplace_back() : share_.back())[t] = piece.cell[t].share;
    const double volume = grid_.edge.prod() / 6;
    for (const auto& shares : share_)
      for (const double share : shares) volume_ += share * volume;
    find_tetrahedra(below);
  }

  double volume() const { return volume_; }

  Mesh mesh(std::shared_ptr<const MaterialField> material) {
    Mesh out;
    number_nodes(out);
    add_tetrahedra(out);
    if (is_quadratic_) add_middles(out);
    add_surface(out);
    embedded_->edge = grid_.edge.mean();
    embedded_->thickness = find_thickness(material_.winding(), material_.surface(), kThick * embedded_->edge);
    embedded_->material = std::move(material);
    out.embedded = std::move(embedded_);
    return out;
  }

 private:
  /// Where the surface's vertices belong: on a face between two tetrahedra to the one with the material.
  std::vector<Vec3> places_below() const {
    constexpr double kBelow = 0.02;  // of an edge
    const VectorX normals = node_normals(surface_.x, surface_.triangles);
    std::vector<Vec3> out;
    for (int v = 0; v < surface_.num_nodes(); ++v)
      out.emplace_back(node(surface_.x, v) - kBelow * grid_.edge.minCoeff() * node(normals, v));
    return out;
  }

  void find_tetrahedra(const std::vector<Vec3>& below) {
    for (std::size_t v = 0; v < below.size(); ++v) {
      const Vec3 corner = grid_.corner(grid_.place_of(cube_of(piece_[v])));
      const int t = kuhn_holding((below[v] - corner).cwiseQuotient(grid_.edge));
      tetrahedron_.push_back(t);
      share_of(piece_[v], t) = std::max(share_of(piece_[v], t), kLeastShare);
    }
    for (auto& shares : share_)
      for (double& share : shares)
        if (share > 0) share = std::max(share, kLeastShare);
  }

  int cube_of(int piece) const { return material_.pieces()[static_cast<std::size_t>(piece)].cube; }
  double& share_of(int piece, int t) { return share_[static_cast<std::size_t>(piece)][static_cast<std::size_t>(t)]; }
  /// Of a piece's tetrahedron, each as the first of those that are the same.
  std::array<int, 4> corners_of(int piece, int t) const {
    std::array<int, 4> out{};
    const auto steps = kuhn_corners(t);
    for (std::size_t c = 0; c < 4; ++c)
      out[c] = corner_[static_cast<std::size_t>(8 * piece + steps[c][0] + 2 * steps[c][1] + 4 * steps[c][2])];
    return out;
  }
  std::array<int, 4> nodes_of(int piece, int t) const {
    std::array<int, 4> out = corners_of(piece, t);
    for (int& i : out) i = node_[static_cast<std::size_t>(i)];
    return out;
  }
  template <class Give>
  void for_tetrahedra(const Give& give) {
    for (int piece = 0; piece < static_cast<int>(share_.size()); ++piece)
      for (int t = 0; t < 6; ++t)
        if (share_of(piece, t) > 0) give(piece, t);
  }

  /// In the order of the lattice's corners.
  void number_nodes(Mesh& out) {
    std::vector<std::pair<int, int>> used;  // corner of the lattice, of pieces
    node_.assign(corner_.size(), -1);
    for_tetrahedra([&](int piece, int t) {
      const auto at = grid_.place_of(cube_of(piece));
      const auto steps = kuhn_corners(t), corners = steps;
      const auto first = corners_of(piece, t);
      for (std::size_t c = 0; c < 4; ++c) {
        if (node_[static_cast<std::size_t>(first[c])] == 0) continue;
        node_[static_cast<std::size_t>(first[c])] = 0;
        used.emplace_back(grid_.node({at[0] + corners[c][0], at[1] + corners[c][1], at[2] + corners[c][2]}), first[c]);
      }
    });
    std::ranges::sort(used);
    out.x.resize(3 * static_cast<Eigen::Index>(used.size()));
    const int wide = grid_.count[0] + 1, high = grid_.count[1] + 1;
    for (std::size_t n = 0; n < used.size(); ++n) {
      const int i = used[n].first;
      node_[static_cast<std::size_t>(used[n].second)] = static_cast<int>(n);
      node(out.x, static_cast<int>(n)) = grid_.corner({i % wide, i / wide % high, i / wide / high});
    }
    embedded_->first = static_cast<int>(used.size());
  }

  void add_tetrahedra(Mesh& out) {
    std::vector<int> piece_of_cell;
    cell_.assign(6 * share_.size(), -1);
    for_tetrahedra([&](int piece, int t) {
      const bool is_first = piece_of_cell.empty() || piece != piece_of_cell.back();
      embedded_->cube.push_back(embedded_->cube.empty() ? 0 : embedded_->cube.back() + is_first);
      cell_[static_cast<std::size_t>(6 * piece + t)] = static_cast<int>(out.tetrahedra.size());
      out.tetrahedra.push_back(nodes_of(piece, t));
      embedded_->share.push_back(share_of(piece, t));
      piece_of_cell.push_back(piece);
    });
    material_.name_cells(std::move(piece_of_cell));
  }

  /// Cells that share two corners share the node between them.
  void add_middles(Mesh& out) {
    std::map<std::array<int, 2>, int> middle;
    std::vector<Vec3> places;
    for (const Tetrahedron& t : out.tetrahedra) {
      std::array<int, 6>& its = embedded_->middles.emplace_back();
      for (std::size_t e = 0; e < 6; ++e) {
        const auto [a, b] = std::minmax(t[kCellEdges[e][0]], t[kCellEdges[e][1]]);
        const auto [found, is_new] = middle.try_emplace({a, b}, embedded_->first + static_cast<int>(places.size()));
        if (is_new) places.push_back(0.5 * (node(out.x, a) + node(out.x, b)));
        its[e] = found->second;
      }
    }
    out.x.conservativeResize(out.x.size() + 3 * static_cast<Eigen::Index>(places.size()));
    for (const Vec3& place : places) node(out.x, embedded_->first++) = place;
    for_tetrahedra([&](int piece, int t) {
      embedded_->points.push_back(
          cell_points(t, material_.pieces()[static_cast<std::size_t>(piece)].cell[static_cast<std::size_t>(t)]));
    });
  }

  void add_surface(Mesh& out) {
    const int nodes = embedded_->first;
    out.x.conservativeResize(out.x.size() + surface_.x.size());
    out.x.tail(surface_.x.size()) = surface_.x;
    for (const Triangle& t : surface_.triangles) out.triangles.push_back({t[0] + nodes, t[1] + nodes, t[2] + nodes});
    for (std::size_t v = 0; v < piece_.size(); ++v) {
      const int piece = piece_[v], t = tetrahedron_[v];
      const Vec3 off = node(surface_.x, static_cast<int>(v)) - grid_.corner(grid_.place_of(cube_of(piece)));
      embedded_->corners.push_back(nodes_of(piece, t));
      embedded_->cell.push_back(cell_[static_cast<std::size_t>(6 * piece + t)]);
      embedded_->weights.push_back(kuhn_weights(t, off.cwiseQuotient(grid_.edge)));
    }
    embedded_->group_triangles(out.triangles);
  }

  const LatticeGrid& grid_;
  const Mesh& surface_;
  LatticeMaterial& material_;
  bool is_quadratic_;
  std::shared_ptr<EmbeddedSurface> embedded_;
  std::vector<int> piece_, tetrahedron_;      // of each vertex
  std::vector<std::array<double, 6>> share_;  // of each piece's tetrahedra
  std::vector<int> corner_, node_;            // of pieces' corners: the first that is the same, the mesh's node
  std::vector<int> cell_;                     // of pieces' tetrahedra
  double volume_ = 0;
};

}  // namespace

std::vector<std::string> LatticeReport::lines() const {
  std::vector<std::string> out{text("object.body lattice: ", nodes, " nodes, ", tetrahedra,
                                    is_quadratic ? " tetrahedra of ten nodes in cubes of " : " tetrahedra in cubes of ",
                                    short_number(1e3 * edge), " mm, ", short_number(1e6 * volume), " cm3 of material")};
  std::vector<std::string> assumed;
  if (open_edges > 0)
    assumed.push_back(text(open_edges, " open edges closed by winding number, ", short_number(100 * unsure),
                           " % of the volume near the surface unsure"));
  if (turned > 0) assumed.push_back(text(turned, " triangles turned to face outward"));
  if (degenerate > 0) assumed.push_back(text(degenerate, " triangles without area left out"));
  for (std::size_t i = 0; i < assumed.size(); ++i) {
    if (i == 0) out.push_back("object.body lattice: ");
    out.back() += (i > 0 ? ", " : "") + assumed[i];
  }
  if (parted_cubes > 0)
    out.push_back(text("object.body lattice: ", parted_cubes, " of ", cut_cubes,
                       " cubes hold pieces of material that are apart in them, each with cells of its own"));
  return out;
}

Mesh make_lattice(const Mesh& surface, const LatticeOptions& options, LatticeReport* report) {
  LatticeReport own;
  LatticeReport& said = report ? *report : own;
  const Mesh clean = clean_surface(surface, said);
  if (clean.triangles.empty()) throw InputError(text(options.name, ": no triangle has an area: there is no body"));
  auto material = std::make_shared<LatticeMaterial>(clean, said.closes);
  if (auto turned = turn_outward(material->surface(), material->winding(), said))
    material = std::make_shared<LatticeMaterial>(std::move(*turned), said.closes);
  const Mesh& turned = material->surface();
  const Bounds box = bounds(clean);
  constexpr double kEmpty = 0.8;  // of the corners of these cubes, those of tetrahedra with material in them
  const int corners = static_cast<int>(options.nodes / kEmpty);
  const double edge = options.edge > 0 ? options.edge : find_edge(box, *material, options, corners);
  const auto refuse = [&](double cubes) {
    throw InputError(text("object.lattice.edge: ", edge, " m makes ", short_number(cubes),
                          " cubes of the body's box, at most ", 50 * kMostLatticeNodes, ": enlarge it"));
  };
  const double cubes = (box.size() / edge).cwiseMax(1).prod();  // as a number that cannot overflow, first
  if (!(cubes <= 50.0 * kMostLatticeNodes)) refuse(cubes);
  const LatticeGrid grid = make_grid(box, edge, options);
  if (grid.num_cubes() > 50 * kMostLatticeNodes) refuse(grid.num_cubes());
  const Mesh surface_in_it = with_short_edges(turned, options.longest * grid.edge.minCoeff());
  LatticeMaker maker(grid, surface_in_it, *material, options.is_quadratic);
  Mesh out = maker.mesh(material);
  said.volume = maker.volume();
  said.unsure = material->unsure();
  said.cut_cubes = material->cut_cubes();
  said.parted_cubes = material->parted_cubes();
  said.nodes = out.num_own_nodes();
  said.tetrahedra = static_cast<int>(out.tetrahedra.size());
  said.edge = grid.edge.mean();
  said.is_quadratic = options.is_quadratic;
  if (!(said.volume > 0))
    throw InputError(text(options.name,
                          ": the surface holds no material: nowhere does it wind around a place more "
                          "than half a time; object.body lattice needs a surface that closes, nearly"));
  if (said.nodes > kMostLatticeNodes)
    throw InputError(text("object.lattice.edge: ", edge, " m makes ", said.nodes, " nodes, at most ", kMostLatticeNodes,
                          ": enlarge it"));
  return out;
}

}  // namespace kt
