#include "core/fine/make_fine_patch.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "core/body/embedded_surface.hpp"
#include "core/body/node_weights.hpp"

namespace kt {
namespace {

/// Facets side by side share whole edges: one whose neighbour is cut in the middle of their edge is cut there, too.
class Closure {
 public:
  Closure(const FineZone& zone) : zone_(zone) {
    for (const Triangle& t : zone.facets)
      for (const int i : t) is_vertex_.insert(i);
    for (std::size_t i = 0; i < zone.nodes.size(); ++i)
      if (is_vertex_.contains(static_cast<int>(i))) number_.emplace(key(zone.nodes[i]), static_cast<int>(i));
  }

  template <class Give>
  void cut(const Triangle& t, const Give& give) const {
    const std::array<int, 3> mid{between(t[0], t[1]), between(t[1], t[2]), between(t[2], t[0])};
    const auto count = std::ranges::count_if(mid, [](int i) { return i >= 0; });
    if (count == 0) return give(t);
    if (count == 3) {
      for (int c = 0; c < 3; ++c) cut({t[c], mid[c], mid[(c + 2) % 3]}, give);
      return cut({mid[0], mid[1], mid[2]}, give);
    }
    // The edge that is cut, or of two the first: what is left of the other one is cut again.
    for (int e = 0; e < 3; ++e) {
      if (mid[e] < 0) continue;
      cut({t[e], mid[e], t[(e + 2) % 3]}, give);
      return cut({mid[e], t[(e + 1) % 3], t[(e + 2) % 3]}, give);
    }
  }

 private:
  using Key = std::array<int, 9>;
  static Key key(const CellPoint& p) {
    Key out{p.count};
    for (int k = 0; k < p.count; ++k) {
      out[1 + k] = p.corner[k];
      out[5 + k] = p.weight[k];
    }
    return out;
  }
  int between(int a, int b) const {
    const auto found = number_.find(key(middle(zone_.nodes[a], zone_.nodes[b])));
    return found == number_.end() ? -1 : found->second;
  }
  const FineZone& zone_;
  std::set<int> is_vertex_;
  std::map<Key, int> number_;
};

/// Of a node in a triangle of the surface, as shares of its corners.
Vec3 weights_in(const FineBody& body, const Triangle& t, const CellPoint& p) {
  Vec3 out = Vec3::Zero();
  if (!body.is_quadratic()) {
    for (int k = 0; k < p.count; ++k)
      for (int c = 0; c < 3; ++c)
        if (t[c] == p.corner[k]) out[c] += p.share(k);
    return out;
  }
  // A quarter of a face: by where the place and the quarter's corners are in the face, in the plane of these.
  const VectorX& x = body.mesh->x;
  const Vec3 at = p.of(x), a = node(x, t[0]), ab = node(x, t[1]) - a, ac = node(x, t[2]) - a, n = ab.cross(ac);
  const double area_sq = n.squaredNorm();
  out[1] = (at - a).cross(ac).dot(n) / area_sq;
  out[2] = ab.cross(at - a).dot(n) / area_sq;
  out[0] = 1 - out[1] - out[2];
  return out;
}

void append_rows(const SparseMatrix& matrix, std::vector<int>& first, std::vector<int>& column,
                 std::vector<double>& value) {
  const Eigen::SparseMatrix<double, Eigen::RowMajor> rows = matrix;
  first.assign(1, 0);
  for (int i = 0; i < rows.outerSize(); ++i) {
    for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator it(rows, i); it; ++it) {
      if (it.value() == 0) continue;
      column.push_back(static_cast<int>(it.col()));
      value.push_back(it.value());
    }
    first.push_back(static_cast<int>(column.size()));
  }
}

/// Of a point in a triangle, as shares of its corners.
Vec3 weights_of(const Triangle& t, const CellPoint& p) {
  Vec3 out = Vec3::Zero();
  for (int k = 0; k < p.count; ++k)
    for (std::size_t c = 0; c < 3; ++c)
      if (t[c] == p.corner[static_cast<std::size_t>(k)]) out[static_cast<Eigen::Index>(c)] += p.share(k);
  return out;
}

/// As the triangle's corners do: its motion is linear between them.
NodeWeights carried_by(const EmbeddedSurface& surface, const CellPoint& p) {
  if (p.count == 1) return surface.carried_by(p.corner[0] - surface.first);
  Vec3 weights = Vec3::Zero();
  std::array<int, 3> corners{p.corner[0], p.corner[1], p.count > 2 ? p.corner[2] : p.corner[0]};
  for (int k = 0; k < p.count; ++k) weights[k] = p.share(k);
  return surface.moved_by(corners, weights);
}

/// Facets are triangles or pieces of them; vertices move as the body's surface does, and yield with nodes of leaves.
void place_embedded(const FineBody& body, const FineZone& zone, FinePatch& out) {
  const EmbeddedFacets& e = zone.embedded;
  const EmbeddedSurface& surface = *body.mesh->embedded;
  out.facets = e.facets;
  out.triangle = e.triangle;
  out.is_place = e.is_place;
  out.apart = e.apart;
  for (std::size_t f = 0; f < e.facets.size(); ++f) {
    const Triangle& t = body.mesh->triangles[static_cast<std::size_t>(e.triangle[f])];
    Mat3& corners = out.corners.emplace_back();
    for (int c = 0; c < 3; ++c)
      corners.col(c) = weights_of(t, e.vertex[static_cast<std::size_t>(e.facets[f][static_cast<std::size_t>(c)])]);
    out.to_facet.push_back(corners.inverse());
  }
  out.first.push_back(0);
  for (const CellPoint& vertex : e.vertex) {
    const NodeWeights carried = carried_by(surface, vertex);
    out.node.insert(out.node.end(), carried.node.begin(), carried.node.begin() + carried.count);
    out.weight.insert(out.weight.end(), carried.weight.begin(), carried.weight.begin() + carried.count);
    out.first.push_back(static_cast<int>(out.node.size()));
  }
  out.first_from = e.first_near;
  out.from = e.near;
  out.share = e.share;
  std::vector<SurfacePlace> place(e.vertex.size());
  for (std::size_t f = 0; f < e.facets.size(); ++f)
    for (int c = 0; c < 3; ++c)
      place[static_cast<std::size_t>(e.facets[f][static_cast<std::size_t>(c)])] = {e.triangle[f],
                                                                                   out.corners[f].col(c)};
  for (const int v : e.places) out.yielding.push_back(place[static_cast<std::size_t>(v)]);
}

}  // namespace

std::vector<int> zone_nodes(const FineBody& body, const FineZone& zone) {
  std::vector<int> out;
  for (const int c : zone.cells) {
    const std::span<const int> nodes = body.material->cell_nodes(c);
    out.insert(out.end(), nodes.begin(), nodes.end());
  }
  std::ranges::sort(out);
  const auto [end, last] = std::ranges::unique(out);
  out.erase(end, last);
  return out;
}

FineOrigin fine_origin(const FineBody& body, const FineZone& zone, FineZoneOptions options, const FineState& state) {
  options.size.edge = zone.edge;
  const std::vector<int> nodes = zone_nodes(body, zone);
  const auto size = 3 * static_cast<Eigen::Index>(nodes.size());
  FineOrigin out{.options = std::move(options), .kind = state.kind, .x = VectorX(size), .v = VectorX(size)};
  for (int i = 0; i < static_cast<int>(nodes.size()); ++i) {
    node(out.x, i) = node(state.coarse.x, nodes[i]);
    node(out.v, i) = node(state.coarse.v, nodes[i]);
  }
  return out;
}

std::shared_ptr<FinePatch> make_fine_patch(const FineBody& body, const FineZone& zone,
                                           std::span<const Triangle> triangles, FineYield yield) {
  auto out = std::make_shared<FinePatch>();
  out->width = zone.width;
  if (body.mesh->embedded) {
    place_embedded(body, zone, *out);
    out->R = std::move(yield.R);
    out->retardation = yield.retardation;
    return out;
  }
  std::vector<std::pair<int, Triangle>> facets;  // of the zone's nodes
  const Closure closure(zone);
  for (std::size_t f = 0; f < zone.facets.size(); ++f)
    closure.cut(zone.facets[f], [&](const Triangle& t) { facets.emplace_back(zone.facet_triangle[f], t); });
  std::ranges::stable_sort(facets, {}, &std::pair<int, Triangle>::first);

  std::map<int, int> vertex;  // of the zone's nodes
  std::vector<int> nodes;
  std::map<int, SurfacePlace> place;  // of the zone's nodes
  for (const auto& [triangle, t] : facets) {
    Triangle& facet = out->facets.emplace_back();
    Mat3 corners;
    for (int c = 0; c < 3; ++c) {
      const auto [found, is_new] = vertex.try_emplace(t[c], static_cast<int>(nodes.size()));
      if (is_new) nodes.push_back(t[c]);
      facet[c] = found->second;
      corners.col(c) = weights_in(body, triangles[static_cast<std::size_t>(triangle)], zone.nodes[t[c]]);
      place.try_emplace(t[c], SurfacePlace{triangle, corners.col(c)});
    }
    out->triangle.push_back(triangle);
    out->corners.push_back(corners);
    out->to_facet.push_back(corners.inverse());
  }
  append_rows(coarse_weights(body, zone, nodes), out->first, out->node, out->weight);

  const int begin = zone.num_unknown() - zone.num_yielding;
  out->first_from.push_back(0);
  for (const int i : nodes) {
    for (int k = zone.first[i]; k < zone.first[i + 1]; ++k)
      if (zone.from[k] >= begin) {
        out->from.push_back(zone.from[k] - begin);
        out->share.push_back(zone.weight[k]);
      }
    out->first_from.push_back(static_cast<int>(out->from.size()));
  }
  for (const int i : zone.yielding()) {
    const auto found = place.find(i);
    out->yielding.push_back(found == place.end() ? SurfacePlace{} : found->second);
  }
  out->R = std::move(yield.R);
  out->retardation = yield.retardation;
  return out;
}

}  // namespace kt
