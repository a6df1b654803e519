#include "core/fine/fine_surface.hpp"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "core/body/embedded_surface.hpp"
#include "core/body/near_triangles.hpp"
#include "core/fine/leaf_stiffness.hpp"

namespace kt {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector4d;

/// The corners of each eighth as shares of the leaf's, a column each.
std::array<Matrix4d, 8> make_eighths() {
  std::array<Vector4d, 10> node;
  for (int c = 0; c < 4; ++c) node[static_cast<std::size_t>(c)] = Vector4d::Unit(c);
  for (std::size_t e = 0; e < 6; ++e)
    node[4 + e] = 0.5 * (Vector4d::Unit(kCellEdges[e][0]) + Vector4d::Unit(kCellEdges[e][1]));
  std::array<Matrix4d, 8> out;
  for (std::size_t i = 0; i < 8; ++i)
    for (int c = 0; c < 4; ++c)
      out[i].col(c) = node[static_cast<std::size_t>(kEighths[i][static_cast<std::size_t>(c)])];
  return out;
}

const std::array<Matrix4d, 8>& eighths() {
  static const std::array<Matrix4d, 8> out = make_eighths();
  return out;
}

/// Shares of a leaf's corners to those of the corners of each eighth.
const std::array<Matrix4d, 8>& to_eighths() {
  static const std::array<Matrix4d, 8> out = [] {
    std::array<Matrix4d, 8> inverse;
    std::ranges::transform(eighths(), inverse.begin(), [](const Matrix4d& m) { return Matrix4d(m.inverse()); });
    return inverse;
  }();
  return out;
}

class EmbeddedFacetMaker {
  static constexpr double kSlack = 1e-9;
  static constexpr double kOutside = 0.1;             // of a cell: a triangle that goes further out is not refined
  static constexpr std::size_t kMostPieces = 50'000;  // of all triangles: no contact needs as many

 public:
  EmbeddedFacetMaker(const FineBody& body, const FineNodes& nodes, FineZone& zone)
      : body_(body), surface_(*body.mesh->embedded), nodes_(nodes), zone_(zone) {
    for (std::size_t i = 0; i < zone.cells.size(); ++i) local_.emplace(zone.cells[i], static_cast<int>(i));
    leaves_.resize(zone.cells.size());
    shares_.resize(zone.leaves.size());
    for (std::size_t l = 0; l < zone.leaves.size(); ++l)
      leaves_[static_cast<std::size_t>(zone.leaves[l].cell)].push_back(static_cast<int>(l));
  }

  /// @param longest  edge of a piece [m]
  void add(int triangle, double longest) {
    const Triangle& t = body_.mesh->triangles[static_cast<std::size_t>(triangle)];
    for (const int v : t)
      if (!local_.contains(cell_of(v))) return;
    EmbeddedFacets& e = zone_.embedded;
    if (e.facets.size() > kMostPieces) longest = 0;
    std::vector<Triangle> pieces;
    cut({corner_point(t[0]), corner_point(t[1]), corner_point(t[2])}, longest, [&](const std::array<CellPoint, 3>& p) {
      pieces.push_back({vertex(p[0]), vertex(p[1]), vertex(p[2])});
    });
    if (std::ranges::any_of(pieces, [](const Triangle& piece) { return std::ranges::min(piece) < 0; })) return;
    e.triangle.insert(e.triangle.end(), pieces.size(), triangle);
    e.facets.insert(e.facets.end(), pieces.begin(), pieces.end());
  }

 private:
  int cell_of(int vertex) const { return surface_.cell[static_cast<std::size_t>(vertex - surface_.first)]; }

  /// Gives the pieces. Whether an edge is cut depends on it alone, so that triangles side by side share theirs.
  template <class Give>
  void cut(const std::array<CellPoint, 3>& p, double longest, const Give& give) const {
    const VectorX& x = body_.mesh->x;
    std::array<bool, 3> is_long;
    for (std::size_t e = 0; e < 3; ++e)
      is_long[e] = longest > 0 && (p[e].of(x) - p[(e + 1) % 3].of(x)).norm() > longest;
    const auto count = std::ranges::count(is_long, true);
    if (count == 0) return give(p);
    const std::array<CellPoint, 3> mid{middle(p[0], p[1]), middle(p[1], p[2]), middle(p[2], p[0])};
    if (count == 3) {
      for (std::size_t c = 0; c < 3; ++c) cut({p[c], mid[c], mid[(c + 2) % 3]}, longest, give);
      return cut({mid[0], mid[1], mid[2]}, longest, give);
    }
    const auto e = static_cast<std::size_t>(std::ranges::find(is_long, true) - is_long.begin());
    cut({p[e], mid[e], p[(e + 2) % 3]}, longest, give);
    cut({mid[e], p[(e + 1) % 3], p[(e + 2) % 3]}, longest, give);
  }

  /// -1: between vertices, and in none of the zone's cells.
  int vertex(const CellPoint& point) {
    const int known = vertex_.find(point);
    if (known >= 0) return known;
    const auto [cell, shares] = point.count == 1 ? cell_with(point.corner[0]) : cell_around(point);
    if (point.count > 1 && shares.minCoeff() < -kOutside) return -1;
    zone_.embedded.vertex.push_back(point);
    locate(cell, shares);
    return vertex_.at(point);
  }

  /// The cell that a vertex moves with, and its shares in the cell's corners.
  std::pair<int, Vector4d> cell_with(int vertex) const {
    const auto v = static_cast<std::size_t>(vertex - surface_.first);
    return {surface_.cell[v], Vector4d(surface_.weights[v].data())};
  }

  /// Shares of a place in the corners of a cell.
  Vector4d shares_in(int cell, const Vec3& place) const {
    Matrix4d corners;
    for (std::size_t c = 0; c < 4; ++c)
      corners.col(static_cast<Eigen::Index>(c)) =
          node(body_.mesh->x, body_.mesh->tetrahedra[static_cast<std::size_t>(cell)][c]).homogeneous();
    return corners.inverse() * place.homogeneous();
  }

  /// The cell of the zone that holds a point between vertices, found from these through the cells' faces.
  std::pair<int, Vector4d> cell_around(const CellPoint& point) const {
    constexpr int kMostCells = 64;
    const Vec3 place = point.of(body_.mesh->x);
    std::vector<int> seen;
    const auto see = [&](int cell) {
      if (cell >= 0 && local_.contains(cell) && std::ranges::find(seen, cell) == seen.end()) seen.push_back(cell);
    };
    for (int k = 0; k < point.count; ++k) see(cell_of(point.corner[static_cast<std::size_t>(k)]));
    std::pair<int, Vector4d> best{-1, Vector4d::Zero()};
    double least = -std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < seen.size() && i < kMostCells; ++i) {
      const Vector4d its = shares_in(seen[i], place);
      if (its.minCoeff() > least) {
        least = its.minCoeff();
        best = {seen[i], its};
      }
      if (least >= -kSlack) break;
      for (const int next : body_.across[static_cast<std::size_t>(seen[i])]) see(next);
    }
    return best;
  }

  /// A leaf in shares of its cell's corners.
  struct LeafShares {
    Matrix4d to_leaf;    ///< those to shares of its own corners
    Vector4d low, high;  ///< of its own corners
  };
  const LeafShares& shares_of(int leaf, const std::array<int, 4>& cell) {
    std::optional<LeafShares>& known = shares_[static_cast<std::size_t>(leaf)];
    if (known) return *known;
    Matrix4d corners = Matrix4d::Zero();
    for (std::size_t c = 0; c < 4; ++c) {
      const CellPoint& p = nodes_[zone_.leaves[static_cast<std::size_t>(leaf)].node[c]];
      for (int k = 0; k < p.count; ++k)
        corners(std::ranges::find(cell, p.corner[static_cast<std::size_t>(k)]) - cell.begin(),
                static_cast<Eigen::Index>(c)) = p.share(k);
    }
    return known.emplace(LeafShares{corners.inverse(), corners.rowwise().minCoeff(), corners.rowwise().maxCoeff()});
  }

  /// The leaf of a cell that holds a place.
  void locate(int cell, const Vector4d& place) {
    double best = -std::numeric_limits<double>::infinity();
    Vector4d shares;
    const FineLeaf* leaf = nullptr;
    const auto look = [&](bool everywhere) {
      for (const int l : leaves_[static_cast<std::size_t>(local_.at(cell))]) {
        const LeafShares& of = shares_of(l, body_.mesh->tetrahedra[static_cast<std::size_t>(cell)]);
        if (!everywhere && ((place - of.low).minCoeff() < -kSlack || (of.high - place).minCoeff() < -kSlack)) continue;
        const Vector4d its = of.to_leaf * place;
        if (!(its.minCoeff() > best)) continue;
        best = its.minCoeff();
        shares = its;
        leaf = &zone_.leaves[static_cast<std::size_t>(l)];
      }
    };
    look(false);
    if (!(best >= 0)) look(true);  // just outside of its cell
    best = -std::numeric_limits<double>::infinity();
    std::array<int, 4> node{};
    std::array<double, 4> weight{};
    for (std::size_t i = 0; i < 8; ++i) {
      const Vector4d its = to_eighths()[i] * shares;
      if (!(its.minCoeff() > best)) continue;
      best = its.minCoeff();
      for (std::size_t c = 0; c < 4; ++c) {
        node[c] = leaf->node[static_cast<std::size_t>(kEighths[i][c])];
        weight[c] = its[static_cast<Eigen::Index>(c)];
      }
    }
    zone_.embedded.node.push_back(node);
    zone_.embedded.weight.push_back(weight);
    zone_.embedded.leaf.push_back(static_cast<int>(leaf - zone_.leaves.data()));
  }

  const FineBody& body_;
  const EmbeddedSurface& surface_;
  const FineNodes& nodes_;
  FineZone& zone_;
  std::map<int, int> local_;  // cells
  FineNodes vertex_;
  std::vector<std::vector<int>> leaves_;
  std::vector<std::optional<LeafShares>> shares_;
};

}  // namespace

void add_embedded_facets(const FineBody& body, const FineNodes& nodes, const FineZoneOptions& options, FineZone& zone) {
  const VectorX& x = body.mesh->x;
  const EmbeddedGroups& groups = body.mesh->embedded->groups;
  std::vector<int> reached;
  for (int g = 0; g < groups.count(); ++g) {
    const auto [low, high] = box_of_group(groups, g, x);
    if (options.least([&](const Vec3& c) { return (c - c.cwiseMax(low).cwiseMin(high)).norm(); }) > options.reach)
      continue;
    for (int k = groups.first_triangle[g]; k < groups.first_triangle[g + 1]; ++k) {
      const Triangle& t = body.mesh->triangles[static_cast<std::size_t>(groups.triangle[k])];
      if (std::ranges::any_of(t, [&](int i) { return options.distance(node(x, i)) <= options.reach; }))
        reached.push_back(groups.triangle[k]);
    }
  }
  std::ranges::sort(reached);
  EmbeddedFacetMaker maker(body, nodes, zone);
  constexpr double kLongestEdge = 2;    // of how far places are apart
  constexpr double kLeastApart = 0.01;  // of the cubes: contacts that need less have no cells that are small enough
  // Large leaves have fewer nodes than there are such places. Not by options.size.edge: what a second computer is sent
  // is the edge that was taken.
  constexpr double kOfLeaf = 1.0 / 3, kWidest = 1.7;
  const double wider = std::clamp(kOfLeaf * zone.largest, options.apart, kWidest * options.apart);
  const double apart = options.apart > 0 ? std::max(wider, kLeastApart * body.mesh->embedded->edge) : 0;
  for (const int t : reached) maker.add(t, kLongestEdge * apart);
  zone.embedded.apart = apart;
}

namespace {

CellPoint middle_of(const CellPoint& a, const CellPoint& b, const CellPoint& c, const CellPoint& d) {
  return middle(middle(a, b), middle(c, d));
}

/// How deep in the material of their cells the nodes of leaves are.
class NodeDepths {
 public:
  NodeDepths(const FineBody& body, const FineNodes& nodes, const FineZone& zone)
      : body_(body), nodes_(nodes), zone_(zone) {}

  bool is_whole(const FineLeaf& leaf) const { return body_.mesh->embedded->material->is_whole(cell(leaf)); }

  double on_surface() const { return 1e-7 * body_.mesh->embedded->edge; }

  double at_middle(const FineLeaf& leaf, const std::array<int, 4>& corners) const {
    const auto point = [&](std::size_t c) -> const CellPoint& { return point_of(leaf, corners[c]); };
    return body_.depths->at(cell(leaf), middle_of(point(0), point(1), point(2), point(3)), body_.mesh->embedded->edge);
  }

  /// @param most  that matters: the leaf's longest edge [m]
  double at(const FineLeaf& leaf, int n, double most) const {
    return body_.depths->at(cell(leaf), point_of(leaf, n), most);
  }

  double longest_edge(const FineLeaf& leaf) const {
    const VectorX& x = body_.mesh->x;
    double out = 0;
    for (const auto& [i, j] : kCellEdges)
      out = std::max(out, (point_of(leaf, i).of(x) - point_of(leaf, j).of(x)).norm());
    return out;
  }

 private:
  int cell(const FineLeaf& leaf) const { return zone_.cells[static_cast<std::size_t>(leaf.cell)]; }
  const CellPoint& point_of(const FineLeaf& leaf, int n) const {
    return nodes_[leaf.node[static_cast<std::size_t>(n)]];
  }

  const FineBody& body_;
  const FineNodes& nodes_;
  const FineZone& zone_;
};

/// Weights of the four points of a tetrahedron by which constant and linear functions are integrated over its
/// material. Where material in a corner asks for a negative weight elsewhere, there is none.
/// @param material  as cut_tetrahedron() gives it
Vector4d point_weights(const Vector4d& material) {
  const Vector4d weights =
      ((material.array() - kFarShare * material.sum()) / (kNearShare - kFarShare)).matrix().cwiseMax(0);
  return material.sum() / weights.sum() * weights;
}

void add_everywhere(double material, std::vector<LeafPoint>& out) {
  for (int q = 0; q < 4; ++q) {
    Vector4d at = Vector4d::Constant(kFarShare);
    at[q] = kNearShare;
    out.push_back({at, 0.25 * material});
  }
}

/// The surface is flat in each eighth.
std::vector<LeafPoint> points_of(const FineLeaf& leaf, const NodeDepths& depths) {
  constexpr double kNone = 1e-6;
  std::vector<LeafPoint> out;
  double share = 0;
  const double longest = depths.longest_edge(leaf);
  for (std::size_t i = 0; i < 8; ++i) {
    Vector4d depth;
    for (int c = 0; c < 4; ++c) depth[c] = depths.at(leaf, kEighths[i][static_cast<std::size_t>(c)], longest);
    if (depth.lpNorm<Eigen::Infinity>() <= depths.on_surface())  // in an edge of the surface that fits the cells
      depth.setConstant(depths.at_middle(leaf, kEighths[i]));
    const Vector4d material = cut_tetrahedron(depth);
    if (material.sum() < kNone) continue;
    share += material.sum() / 8;
    if (material.sum() > 1 - kNone) {
      out.push_back({eighths()[i] * Vector4d::Constant(0.25), 1.0 / 8});
      continue;
    }
    const Vector4d weights = point_weights(material);
    for (int q = 0; q < 4; ++q) {
      Vector4d at = Vector4d::Constant(kFarShare);
      at[q] = kNearShare;
      if (weights[q] > 0) out.push_back({eighths()[i] * at, weights[q] / 8});
    }
  }
  if (share > 1 - kNone) return {};
  add_everywhere(kLeastMaterial, out);  // what is no material is next to nothing
  return out;
}

}  // namespace

bool holds_nothing(const FineBody& body, int cell, const std::array<CellPoint, 4>& corners) {
  if (!body.depths || body.mesh->embedded->material->is_whole(cell)) return false;
  const CellPoint at = middle_of(corners[0], corners[1], corners[2], corners[3]);
  const Vec3 middle = at.of(body.mesh->x);
  double reach = 0;
  for (const CellPoint& corner : corners) reach = std::max(reach, (corner.of(body.mesh->x) - middle).norm());
  return body.depths->at(cell, at, reach) <= -reach;
}

std::vector<std::vector<LeafPoint>> leaf_points(const FineBody& body, const FineNodes& nodes, const FineZone& zone) {
  std::vector<std::vector<LeafPoint>> out;
  if (!body.mesh->embedded) return out;
  const NodeDepths depths(body, nodes, zone);
  for (const FineLeaf& leaf : zone.leaves) {
    out.emplace_back();
    if (leaf.is_empty)
      add_everywhere(kEmptyMaterial, out.back());
    else if (!depths.is_whole(leaf))
      out.back() = points_of(leaf, depths);
  }
  return out;
}

}  // namespace kt
