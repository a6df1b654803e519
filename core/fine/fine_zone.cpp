#include "core/fine/fine_zone.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "core/base/stages.hpp"
#include "core/fine/fine_refinement.hpp"
#include "core/fine/fine_surface.hpp"

namespace kt {
namespace {

/// Cells with a corner within the radius of the centre, or that the ball of wanted finest size meets.
std::vector<int> choose_cells(const Mesh& mesh, const FineZoneOptions& o) {
  const std::vector<Tetrahedron>& cells = mesh.tetrahedra;
  std::vector<int> out;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    std::array<Vec3, 4> p;
    double nearest = std::numeric_limits<double>::infinity();
    for (int c = 0; c < 4; ++c) {
      p[c] = node(mesh.x, cells[i][c]);
      nearest = std::min(nearest, o.distance(p[c]));
    }
    if (nearest <= (1 + 1e-9) * o.radius || o.least([&](const Vec3& c) { return least_distance(p, c); }) < o.size.flat)
      out.push_back(static_cast<int>(i));
  }
  return out;
}

/// Of a node that hangs on others of a larger leaf: these, with weights. None: it hangs on nothing.
class Masters {
 public:
  Masters() = default;
  Masters(std::initializer_list<std::pair<int, double>> all) : count_(all.size()) {
    std::ranges::copy(all, of_.begin());
  }
  bool empty() const { return count_ == 0; }
  auto begin() const { return of_.begin(); }
  auto end() const { return of_.begin() + static_cast<std::ptrdiff_t>(count_); }

 private:
  std::size_t count_ = 0;
  std::array<std::pair<int, double>, 5> of_{};
};

/// What is made step by step of the leaves.
class ZoneMaker {
 public:
  ZoneMaker(const FineBody& body, const FineZoneOptions& options)
      : body_(body), x_(body.mesh->x), cells_(body.mesh->tetrahedra), options_(options) {
    zone_.cells = choose_cells(*body.mesh, options);
    zone_.width = options.size.flat;
    is_chosen_.assign(cells_.size(), 0);
    for (const int c : zone_.cells) is_chosen_[c] = 1;
    find_walls();
  }

  /// False: it has too many unknown nodes.
  bool make(double edge, double flat) {
    FineSize size = options_.size;
    size.edge = zone_.edge = edge;
    size.flat = zone_.flat = flat;
    nodes_.clear();
    zone_.leaves.clear();
    for (const CornerLeaf& leaf : refine_cells(body_, zone_.cells, options_, size, nodes_)) {
      FineLeaf& added = zone_.leaves.emplace_back(FineLeaf{{}, leaf.cell, leaf.level, leaf.is_empty});
      std::ranges::copy(leaf.corner, added.node.begin());
    }
    for (FineLeaf& leaf : zone_.leaves)
      for (int e = 0; e < 6; ++e)
        leaf.node[4 + e] = nodes_.between(leaf.node[kCellEdges[e][0]], leaf.node[kCellEdges[e][1]]);
    find_hanging();
    find_held();
    int unknown = 0;
    for (int i = 0; i < nodes_.size(); ++i) unknown += !is_held_[i] && hangs_on_[i].empty();
    return unknown <= options_.most_nodes;
  }

  int num_cells() const { return static_cast<int>(zone_.cells.size()); }
  bool refines() const { return zone_.leaves.size() > zone_.cells.size(); }

  FineZone take() {
    for (int i = 0; i < nodes_.size(); ++i) zone_.nodes.push_back(nodes_[i]);
    find_inner();
    zone_.largest = largest_leaf();
    if (body_.mesh->embedded)
      add_embedded_facets(body_, nodes_, options_, zone_);
    else
      add_facets(body_, nodes_, options_, zone_);
    zone_.leaf_points = leaf_points(body_, nodes_, zone_);
    if (body_.mesh->embedded) find_empty_leaves();
    number_unknown();
    if (body_.mesh->embedded) choose_places(x_, zone_);
    return std::move(zone_);
  }

 private:
  double largest_leaf() const {
    double out = 0;
    for (const FineLeaf& leaf : zone_.leaves) {
      if (leaf.is_empty) continue;
      std::array<Vec3, 4> p;
      for (int c = 0; c < 4; ++c) p[c] = nodes_[leaf.node[c]].of(x_);
      if (const double size = leaf_size(p); away(p, size, options_) <= zone_.flat) out = std::max(out, size);
    }
    return out;
  }

  /// Faces, edges and corners that the zone shares with the rest: they are held.
  void find_walls() {
    std::vector<char> is_zone(static_cast<std::size_t>(x_.size() / 3), 0);
    is_shared_.assign(is_zone.size(), 0);
    for (const int c : zone_.cells)
      for (int f = 0; f < 4; ++f) {
        is_zone[cells_[c][f]] = 1;
        if (const int other = body_.across[c][f]; other >= 0 && !is_chosen_[other])
          walls_.insert(ascending(face_of(cells_[c], f)));
      }
    for (std::size_t c = 0; c < cells_.size(); ++c) {
      if (is_chosen_[c]) continue;
      for (const int i : cells_[c]) is_shared_[i] = is_zone[i];
      for (const auto& [i, j] : kCellEdges)
        if (const int a = cells_[c][i], b = cells_[c][j]; is_zone[a] && is_zone[b])
          wall_edges_.insert({std::min(a, b), std::max(a, b)});
    }
  }

  bool lies_on_wall(const CellPoint& p) const {
    if (p.count == 1) return is_shared_[p.corner[0]];
    if (p.count == 2) return wall_edges_.contains({p.corner[0], p.corner[1]});
    return p.count == 3 && walls_.contains({p.corner[0], p.corner[1], p.corner[2]});
  }

  bool is_held(const CellPoint& p) const {
    bool is_fixed = true;
    for (int k = 0; k < p.count; ++k) is_fixed = is_fixed && body_.is_fixed[p.corner[k]];
    return is_fixed || lies_on_wall(p);
  }

  /// What only empty leaves have is held, too.
  void find_held() {
    std::vector<char> is_needed(static_cast<std::size_t>(nodes_.size()), 0);
    for (const FineLeaf& leaf : zone_.leaves)
      for (const int i : leaf.node)
        if (!leaf.is_empty) need(i, is_needed);
    is_held_.clear();
    for (int i = 0; i < nodes_.size(); ++i) is_held_.push_back(!is_needed[i] || is_held(nodes_[i]));
  }

  /// With what it hangs on.
  void need(int i, std::vector<char>& is_needed) const {
    if (std::exchange(is_needed[i], 1)) return;
    for (const auto& [master, share] : hangs_on_[i]) need(master, is_needed);
  }

  /// Those whose points say so, and that hold no vertex of the surface in reach.
  void find_empty_leaves() {
    std::vector<char> is_met(zone_.leaves.size(), 0);
    for (const int l : zone_.embedded.leaf) is_met[l] = 1;
    for (std::size_t l = 0; l < zone_.leaf_points.size(); ++l) {
      std::vector<LeafPoint>& points = zone_.leaf_points[l];
      double material = 0;
      for (const LeafPoint& p : points) material += p.weight;
      if (is_met[l] || points.empty() || zone_.leaves[l].is_empty || material > (1 + 1e-9) * kLeastMaterial) continue;
      zone_.leaves[l].is_empty = true;
      for (LeafPoint& p : points) p.weight *= kEmptyMaterial / kLeastMaterial;
    }
    find_hanging();
    find_held();
  }

  /// Nodes of smaller leaves on the edges and faces of larger ones go as the larger one's quadratic field does.
  void find_hanging() {
    hangs_on_.assign(static_cast<std::size_t>(nodes_.size()), Masters());
    const auto hang = [&](const CellPoint& p, std::initializer_list<std::pair<int, double>> masters) {
      if (const int i = nodes_.find(p); i >= 0) hangs_on_[i] = masters;
    };
    // Of corners i and j the middle of their edge among a leaf's nodes.
    constexpr int kMiddle[4][4] = {{-1, 4, 6, 7}, {4, -1, 5, 8}, {6, 5, -1, 9}, {7, 8, 9, -1}};
    const int most = deepest(zone_.leaves);
    for (const FineLeaf& leaf : zone_.leaves)
      for (int i = 0; i < 4 && leaf.level < most && !leaf.is_empty; ++i)
        for (int j = 0; j < 4; ++j) {
          if (i == j) continue;
          const int a = leaf.node[i], b = leaf.node[j], ab = leaf.node[kMiddle[i][j]];
          hang(middle(nodes_[a], nodes_[ab]), {{a, 3.0 / 8}, {ab, 3.0 / 4}, {b, -1.0 / 8}});
          for (int k = j + 1; k < 4; ++k) {
            if (k == i) continue;
            const int c = leaf.node[k], ac = leaf.node[kMiddle[i][k]], bc = leaf.node[kMiddle[j][k]];
            hang(middle(nodes_[ab], nodes_[ac]), {{b, -1.0 / 8}, {c, -1.0 / 8}, {ab, 0.5}, {ac, 0.5}, {bc, 0.25}});
          }
        }
  }

  void find_inner() {
    std::set<int> inner;
    for (const int c : zone_.cells) {
      for (const int i : cells_[c])
        if (!is_held(corner_point(i))) inner.insert(i);
      if (!body_.is_quadratic()) continue;
      for (const auto& [i, j] : kCellEdges) {
        const CellPoint p = middle(corner_point(cells_[c][i]), corner_point(cells_[c][j]));
        if (!is_held(p)) inner.insert(body_.edge_node.at({p.corner[0], p.corner[1]}));
      }
    }
    zone_.inner.assign(inner.begin(), inner.end());
  }

  /// The unknown nodes that a node follows, with weights, added up.
  void add_masters(int i, double weight, std::map<int, double>& sum) const {
    if (is_held_[i]) return;
    if (hangs_on_[i].empty()) {
      sum[i] += weight;
      return;
    }
    for (const auto& [master, share] : hangs_on_[i]) add_masters(master, weight * share, sum);
  }

  void number_unknown() {
    std::vector<std::map<int, double>> follows(zone_.nodes.size());
    std::vector<char> is_in_reach(zone_.nodes.size(), 0), is_last(zone_.nodes.size(), 0);
    for (std::size_t f = 0; f < zone_.facets.size(); ++f)
      for (const int i : zone_.facets[f]) is_in_reach[i] |= zone_.facet_in_reach[f];
    for (const auto& nodes : zone_.embedded.node)
      for (const int i : nodes) is_in_reach[i] = 1;
    for (int i = 0; i < nodes_.size(); ++i) {
      add_masters(i, 1, follows[i]);
      if (is_in_reach[i])
        for (const auto& [master, weight] : follows[i]) is_last[master] = 1;
    }
    std::vector<int> number(zone_.nodes.size(), -1);
    for (const bool last : {false, true})
      for (int i = 0; i < nodes_.size(); ++i)
        if (!is_held_[i] && hangs_on_[i].empty() && (is_last[i] != 0) == last) {
          number[i] = static_cast<int>(zone_.unknown.size());
          zone_.unknown.push_back(i);
        }
    zone_.num_yielding = static_cast<int>(std::ranges::count(is_last, 1));
    zone_.first.push_back(0);
    for (const auto& masters : follows) {
      for (const auto& [master, weight] : masters)
        if (weight != 0) {
          zone_.from.push_back(number[master]);
          zone_.weight.push_back(weight);
        }
      zone_.first.push_back(static_cast<int>(zone_.from.size()));
    }
  }

  const FineBody& body_;
  const VectorX& x_;
  const std::vector<Tetrahedron>& cells_;
  const FineZoneOptions& options_;
  FineZone zone_;
  FineNodes nodes_;
  std::vector<char> is_chosen_, is_shared_;  // cells; nodes of the body that cells outside have
  std::set<Triangle> walls_;                 // ascending corners
  std::set<std::array<int, 2>> wall_edges_;
  std::vector<char> is_held_;
  std::vector<Masters> hangs_on_;
};

/// As far as the nodes go: leaves that small in all of `flat`, or in less of it, but not less than least_flat. False:
/// it takes too many nodes.
bool make_of_edge(ZoneMaker& maker, const FineSize& size, double edge) {
  if (maker.make(edge, size.flat)) return true;
  const double least = size.least_flat > 0 ? std::min(size.least_flat, size.flat) : size.flat;
  if (!maker.refines() || !(least < size.flat && maker.make(edge, least))) return false;
  if (!maker.make(edge, std::sqrt(least * size.flat))) maker.make(edge, least);
  return true;
}

}  // namespace

FineZone make_fine_zone(const FineBody& body, const FineZoneOptions& options) {
  const Stage stage("fine.zone");
  ZoneMaker maker(body, options);
  for (double edge = options.size.edge;; edge *= 1.25) {
    if (make_of_edge(maker, options.size, edge)) return maker.take();
    if (!maker.refines()) return {};
  }
}

FineZone make_fine_zone_of_size(const FineBody& body, const FineZoneOptions& options) {
  const Stage stage("fine.zone");
  ZoneMaker maker(body, options);
  const bool has_few = maker.num_cells() <= options.most_nodes;  // nearly every cell adds a node
  return has_few && make_of_edge(maker, options.size, options.size.edge) ? maker.take() : FineZone();
}

}  // namespace kt
