#include "core/fine/fine_surface.hpp"

#include <set>

namespace kt {
namespace {

class FacetMaker {
 public:
  FacetMaker(const FineBody& body, const FineNodes& nodes, const FineZoneOptions& options, FineZone& zone)
      : body_(body), nodes_(nodes), options_(options), zone_(zone) {}

  /// Of a leaf in a cell whose face f is the body's surface.
  void add(const FineLeaf& leaf, const Triangle& face) {
    const VectorX& x = body_.mesh->x;
    const Vec3 a = node(x, face[0]), outwards = (node(x, face[1]) - a).cross(node(x, face[2]) - a);
    for (const auto& corners : kFaceCorners) {
      Triangle c{leaf.node[corners[0]], leaf.node[corners[1]], leaf.node[corners[2]]};
      if (!std::ranges::all_of(c, [&](int i) { return nodes_[i].lies_on(face); })) continue;
      const Vec3 p = nodes_[c[0]].of(x);
      if ((nodes_[c[1]].of(x) - p).cross(nodes_[c[2]].of(x) - p).dot(outwards) < 0) std::swap(c[1], c[2]);
      const auto mid = [&](int i, int j) { return nodes_.find(middle(nodes_[c[i]], nodes_[c[j]])); };
      const int ab = mid(0, 1), bc = mid(1, 2), ca = mid(2, 0);
      for (const Triangle& t : {Triangle{c[0], ab, ca}, {ab, c[1], bc}, {ca, bc, c[2]}, {ab, bc, ca}})
        add_flat(t, face);
    }
  }

 private:
  void add_flat(const Triangle& t, const Triangle& face) {
    const auto is_near = [&](int i) { return options_.distance(nodes_[i].of(body_.mesh->x)) <= options_.reach; };
    const auto found = body_.triangle.find(ascending(triangle_of(t, face)));
    if (found == body_.triangle.end()) return;  // no part of the surface that may be touched
    zone_.facets.push_back(t);
    zone_.facet_triangle.push_back(found->second);
    zone_.facet_in_reach.push_back(std::ranges::any_of(t, is_near));
  }

  /// The body's triangle that a facet is a piece of: the face, or of a quadratic cell a quarter of it.
  Triangle triangle_of(const Triangle& facet, const Triangle& face) const {
    if (!body_.is_quadratic()) return face;
    Vec3 share = Vec3::Zero();  // of the face's corners in the facet's middle
    for (const int i : facet)
      for (int k = 0; k < nodes_[i].count; ++k)
        for (int c = 0; c < 3; ++c)
          if (face[c] == nodes_[i].corner[k]) share[c] += nodes_[i].share(k) / 3;
    const auto between = [&](int i, int j) {
      return body_.edge_node.at({std::min(face[i], face[j]), std::max(face[i], face[j])});
    };
    const int ab = between(0, 1), bc = between(1, 2), ca = between(2, 0);
    if (share[0] > 0.5) return {face[0], ab, ca};
    if (share[1] > 0.5) return {face[1], ab, bc};
    if (share[2] > 0.5) return {face[2], bc, ca};
    return {ab, bc, ca};
  }

  const FineBody& body_;
  const FineNodes& nodes_;
  const FineZoneOptions& options_;
  FineZone& zone_;
};

}  // namespace

namespace {

/// Triangles none of whose pieces is in reach stay as they are.
void keep_reached(FineZone& zone) {
  std::set<int> reached;
  for (std::size_t f = 0; f < zone.facets.size(); ++f)
    if (zone.facet_in_reach[f]) reached.insert(zone.facet_triangle[f]);
  std::size_t kept = 0;
  for (std::size_t f = 0; f < zone.facets.size(); ++f) {
    if (!reached.contains(zone.facet_triangle[f])) continue;
    zone.facets[kept] = zone.facets[f];
    zone.facet_triangle[kept] = zone.facet_triangle[f];
    zone.facet_in_reach[kept++] = zone.facet_in_reach[f];
  }
  zone.facets.resize(kept);
  zone.facet_triangle.resize(kept);
  zone.facet_in_reach.resize(kept);
}

}  // namespace

void add_facets(const FineBody& body, const FineNodes& nodes, const FineZoneOptions& options, FineZone& zone) {
  FacetMaker maker(body, nodes, options, zone);
  for (const FineLeaf& leaf : zone.leaves) {
    const int cell = zone.cells[leaf.cell];
    for (int f = 0; f < 4; ++f)
      if (body.across[cell][f] < 0) maker.add(leaf, face_of(body.mesh->tetrahedra[cell], f));
  }
  keep_reached(zone);
}

}  // namespace kt
