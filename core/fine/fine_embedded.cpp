#include "core/fine/fine_embedded.hpp"

#include <Eigen/LU>
#include <limits>
#include <map>
#include <optional>

#include "core/body/near_triangles.hpp"
#include "core/fine/leaf_stiffness.hpp"

namespace kt {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector4d;

/// The eight tetrahedra between a leaf's corners and the middles of its edges: four at the corners, four around the
/// diagonal between the middles of edges 20 and 13.
constexpr std::array<std::array<int, 4>, 8> kEighths{
    {{0, 4, 6, 7}, {1, 4, 5, 8}, {2, 5, 6, 9}, {3, 7, 8, 9}, {6, 8, 4, 5}, {6, 8, 5, 9}, {6, 8, 9, 7}, {6, 8, 7, 4}}};

/// Shares of a leaf's corners to those of the corners of each eighth.
std::array<Matrix4d, 8> make_eighths() {
  std::array<Vector4d, 10> node;
  for (int c = 0; c < 4; ++c) node[static_cast<std::size_t>(c)] = Vector4d::Unit(c);
  for (std::size_t e = 0; e < 6; ++e)
    node[4 + e] = 0.5 * (Vector4d::Unit(kCellEdges[e][0]) + Vector4d::Unit(kCellEdges[e][1]));
  std::array<Matrix4d, 8> out;
  for (std::size_t i = 0; i < 8; ++i) {
    Matrix4d corners;
    for (int c = 0; c < 4; ++c)
      corners.col(c) = node[static_cast<std::size_t>(kEighths[i][static_cast<std::size_t>(c)])];
    out[i] = corners.inverse();
  }
  return out;
}

class EmbeddedFacetMaker {
 public:
  EmbeddedFacetMaker(const FineBody& body, const FineNodes& nodes, FineZone& zone)
      : body_(body), surface_(*body.mesh->embedded), nodes_(nodes), zone_(zone) {
    for (std::size_t i = 0; i < zone.cells.size(); ++i) local_.emplace(zone.cells[i], static_cast<int>(i));
    leaves_.resize(zone.cells.size());
    to_leaf_.resize(zone.leaves.size());
    for (std::size_t l = 0; l < zone.leaves.size(); ++l)
      leaves_[static_cast<std::size_t>(zone.leaves[l].cell)].push_back(static_cast<int>(l));
  }

  void add(int triangle) {
    const Triangle& t = body_.mesh->triangles[static_cast<std::size_t>(triangle)];
    for (const int v : t)
      if (!local_.contains(surface_.cell[static_cast<std::size_t>(v - surface_.first)])) return;
    zone_.embedded.triangle.push_back(triangle);
    zone_.embedded.facets.push_back({vertex(t[0]), vertex(t[1]), vertex(t[2])});
  }

 private:
  int vertex(int global) {
    EmbeddedFacets& e = zone_.embedded;
    const auto [found, is_new] = vertex_.try_emplace(global, static_cast<int>(e.vertex.size()));
    if (is_new) locate(global);
    return found->second;
  }

  /// Shares of a cell's corners to those of a leaf's.
  const Matrix4d& to_leaf(int leaf, const std::array<int, 4>& cell) {
    std::optional<Matrix4d>& known = to_leaf_[static_cast<std::size_t>(leaf)];
    if (known) return *known;
    Matrix4d corners = Matrix4d::Zero();
    for (std::size_t c = 0; c < 4; ++c) {
      const CellPoint& p = nodes_[zone_.leaves[static_cast<std::size_t>(leaf)].node[c]];
      for (int k = 0; k < p.count; ++k)
        corners(std::ranges::find(cell, p.corner[static_cast<std::size_t>(k)]) - cell.begin(),
                static_cast<Eigen::Index>(c)) = p.share(k);
    }
    return known.emplace(corners.inverse());
  }

  void locate(int global) {
    static const std::array<Matrix4d, 8> kInEighth = make_eighths();
    const auto v = static_cast<std::size_t>(global - surface_.first);
    const Vector4d place(surface_.weights[v].data());
    double best = -std::numeric_limits<double>::infinity();
    Vector4d shares;
    const FineLeaf* leaf = nullptr;
    for (const int l : leaves_[static_cast<std::size_t>(local_.at(surface_.cell[v]))]) {
      const Vector4d its = to_leaf(l, surface_.corners[v]) * place;
      if (!(its.minCoeff() > best)) continue;
      best = its.minCoeff();
      shares = its;
      leaf = &zone_.leaves[static_cast<std::size_t>(l)];
    }
    best = -std::numeric_limits<double>::infinity();
    std::array<int, 4> node{};
    std::array<double, 4> weight{};
    for (std::size_t i = 0; i < 8; ++i) {
      const Vector4d its = kInEighth[i] * shares;
      if (!(its.minCoeff() > best)) continue;
      best = its.minCoeff();
      for (std::size_t c = 0; c < 4; ++c) {
        node[c] = leaf->node[static_cast<std::size_t>(kEighths[i][c])];
        weight[c] = its[static_cast<Eigen::Index>(c)];
      }
    }
    zone_.embedded.vertex.push_back(global);
    zone_.embedded.node.push_back(node);
    zone_.embedded.weight.push_back(weight);
  }

  const FineBody& body_;
  const EmbeddedSurface& surface_;
  const FineNodes& nodes_;
  FineZone& zone_;
  std::map<int, int> local_, vertex_;  // cells; vertices
  std::vector<std::vector<int>> leaves_;
  std::vector<std::optional<Matrix4d>> to_leaf_;
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
  for (const int t : reached) maker.add(t);
}

std::vector<Eigen::Vector4d> leaf_weights(const FineBody& body, const FineNodes& nodes, const FineZone& zone) {
  constexpr double kLeast = 1e-3;
  std::vector<Vector4d> out;
  if (!body.mesh->embedded) return out;
  for (const FineLeaf& leaf : zone.leaves) {
    std::array<Vec3, 4> corners;
    for (std::size_t c = 0; c < 4; ++c) corners[c] = nodes[leaf.node[c]].of(body.mesh->x);
    const Vector4d shares = body.mesh->embedded->samples.shares(corners);
    const double share = std::max(kLeast, shares.sum());
    // Point q is at kNearShare of corner q and kFarShare of the others. Where material in a corner asks for a negative
    // weight elsewhere, there is none.
    Vector4d weights = (shares.array() - kFarShare * shares.sum()) / (kNearShare - kFarShare);
    weights = weights.cwiseMax(0.25 * kLeast);
    out.push_back(share / weights.sum() * weights);
  }
  return out;
}

}  // namespace kt
