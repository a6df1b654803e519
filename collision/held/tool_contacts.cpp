#include "collision/held/tool_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "collision/shape/closest_point.hpp"

namespace kt {
namespace {

constexpr std::size_t kMostPairs = 4096;  // of each kind

Vec3 corner_of(const SurfacePatch& patch, const VectorX& x, int triangle, int c) noexcept {
  return node(x, patch.triangles[triangle][c % 3]);
}

ClosestPoint closest(const SurfacePatch& patch, const VectorX& x, int triangle, const Vec3& p) noexcept {
  const Triangle& t = patch.triangles[triangle];
  return closest_point_on_triangle(p, node(x, t[0]), node(x, t[1]), node(x, t[2]));
}

Box box_of(const Vec3& a, const Vec3& b, double margin) noexcept {
  return {a.cwiseMin(b).array() - margin, a.cwiseMax(b).array() + margin};
}

Box box_of(const Vec3& a, const Vec3& b, const Vec3& c) noexcept {
  return {a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c)};
}

Box grown(Box box, double margin) noexcept {
  box.low.array() -= margin;
  box.high.array() += margin;
  return box;
}

bool holds(const Box& box, const Vec3& p) noexcept {
  return (p.array() >= box.low.array()).all() && (p.array() <= box.high.array()).all();
}

bool is_apart(const Box& box, const Vec3& a, const Vec3& b) noexcept {
  return kt::is_apart(box, Box{a.cwiseMin(b), a.cwiseMax(b)});
}

/// Contacts of one direction within a part of a triangle push the same nodes the same way: the deepest stands for all.
struct Apart {
  double spacing;  // of a triangle's first edge
  double along;    // cosine between normals
};
constexpr Apart kFlat{0.02, 0.9999};
/// The pieces of a smooth surface are much smaller than what its nodes move, and turn little from one to the next.
/// A capsule of 20 mm on pieces of 1.25 mm: a third of the time with kFlat, and no contact is left over that the solver
/// has no room for.
constexpr Apart kCurved{0.5, 0.999};

void add_apart(ContactSet& set, const Contact& contact, double spacing_sq, double along) noexcept {
  for (int i = 0; i < set.count; ++i) {
    Contact& other = set.contacts[i];
    if ((other.core - contact.core).squaredNorm() > spacing_sq || other.normal.dot(contact.normal) < along) continue;
    if (contact.gap < other.gap) other = contact;
    return;
  }
  set.add(contact);
}

/// One search: the features of a tool at rest and of a surface at rest, with distances up to `limit`.
class Search {
 public:
  Search(const SurfacePatch& patch, const VectorX& x, const ToolCore& core, double radius, double margin,
         ContactSet& out)
      : patch_(patch), x_(x), core_(core), radius_(radius), margin_(margin), limit_(radius + margin), out_(out) {}

  /// Each vertex of the candidates once.
  void gather_vertices(std::span<const int> candidates, NearFeatures& near) const noexcept {
    near.vertices.clear();
    for (const int t : candidates)
      for (const int v : patch_.triangles[t])
        if (!std::exchange(near.is_seen[v], 1)) near.vertices.push_back(v);
    for (const int v : near.vertices) near.is_seen[v] = 0;
  }

  /// Box of the candidates' vertices, and whether none of these has moved by more than the slack.
  bool is_still_near(const NearFeatures& near, Box& box) const noexcept {
    box = {Vec3::Constant(std::numeric_limits<double>::infinity()), {}};
    box.high = -box.low;
    double farthest_sq = 0;
    for (const int v : near.vertices) {
      const Vec3 at = node(x_, v);
      box.low = box.low.cwiseMin(at);
      box.high = box.high.cwiseMax(at);
      farthest_sq = std::max(farthest_sq, (at - node(near.x, v)).squaredNorm());
    }
    return farthest_sq <= near.slack * near.slack;
  }

  /// Lists the pairs that are within `reach` of one another now. Those that there is no room for are looked at at once.
  void gather_pairs(std::span<const int> candidates, double reach, const Box& body, NearFeatures& near) noexcept {
    near.corner_faces.clear();
    near.edge_edges.clear();
    near.face_vertices.clear();
    near.is_known = true;
    const Box whole = grown(body, reach);
    for (const int t : candidates) near.is_candidate[t] = 1;
    for (const int corner : core_.features->corners) {
      const Vec3& p = core_.corners[corner];
      if (!holds(whole, p)) continue;
      for (const int t : candidates)
        if (holds(grown(box_of(corner_of(patch_, x_, t, 0), corner_of(patch_, x_, t, 1), corner_of(patch_, x_, t, 2)),
                        reach),
                  p))
          note(near.corner_faces, {corner, t}, near);
    }
    const auto& edges = core_.features->edges;
    for (int i = 0; i < static_cast<int>(edges.size()); ++i) {
      const Vec3 &a = core_.corners[edges[i][0]], &b = core_.corners[edges[i][1]];
      if (is_apart(whole, a, b)) continue;
      const Box box = box_of(a, b, reach);
      for (const int t : candidates)
        for (int c = 0; c < 3; ++c) {
          const int across = patch_.topology.across[t][c];
          if (across >= 0 && across < t && near.is_candidate[across]) continue;  // it has the edge
          const Vec3 p = corner_of(patch_, x_, t, c), q = corner_of(patch_, x_, t, c + 1);
          if (is_apart(box, p, q)) continue;
          const auto [s, u] = closest_parameters(a, b, p, q);
          if ((a + s * (b - a) - p - u * (q - p)).squaredNorm() <= reach * reach)
            note(near.edge_edges, {i, t, c}, near);
        }
    }
    for (int f = 0; f < static_cast<int>(core_.triangles.size()); ++f) {
      const Triangle& face = core_.triangles[f];
      const Box box = grown(box_of(core_.corners[face[0]], core_.corners[face[1]], core_.corners[face[2]]), reach);
      if (kt::is_apart(box, body)) continue;
      for (const int v : near.vertices)
        if (holds(box, node(x_, v))) note(near.face_vertices, {f, v}, near);
    }
    for (const int t : candidates) near.is_candidate[t] = 0;
  }

  void add(const Vec3& place, int triangle) noexcept {
    if (const auto contact = find_sphere_contact(patch_, x_, place, radius_, margin_, triangle)) add(*contact);
  }

  /// Where an edge of the tool is nearest to one of the surface.
  void visit(const NearFeatures::EdgeEdge& pair) noexcept {
    const auto& [i, k] = core_.features->edges[pair.tool_edge];
    const Vec3 &a = core_.corners[i], &b = core_.corners[k];
    const Vec3 p = corner_of(patch_, x_, pair.triangle, pair.edge),
               q = corner_of(patch_, x_, pair.triangle, pair.edge + 1);
    const auto [s, u] = closest_parameters(a, b, p, q);
    if (!(s > 0 && s < 1)) return;
    const Vec3 place = (1 - s) * a + s * b;
    if ((place - p - u * (q - p)).squaredNorm() > limit_ * limit_) return;
    const int other = patch_.topology.across[pair.triangle][pair.edge];
    if (other < 0) {
      // An open edge, or one of more than two triangles, each of which comes with its own.
      return add(place, pair.triangle);
    }
    const auto edge_of = [&](int triangle, const ClosestPoint& at) {  // it is on this very edge
      const Triangle &t = patch_.triangles[triangle], &own = patch_.triangles[pair.triangle];
      const int first = own[pair.edge], second = own[(pair.edge + 1) % 3];
      const int from = t[at.feature_index], to = t[(at.feature_index + 1) % 3];
      return at.feature == ClosestPoint::Feature::edge &&
             ((from == first && to == second) || (from == second && to == first));
    };
    const ClosestPoint here = closest(patch_, x_, pair.triangle, place), there = closest(patch_, x_, other, place);
    if (!edge_of(pair.triangle, here) || !edge_of(other, there)) {
      add(place, pair.triangle);
      add(place, other);
      return;
    }
    const Vec3 outward = face_normal(patch_, x_, pair.triangle) + face_normal(patch_, x_, other);
    const bool is_here = pair.triangle < other;
    add_at(place, is_here ? pair.triangle : other, is_here ? here : there, outward);
  }

  /// Where a side of the tool is nearest to a vertex of the surface.
  void visit(const NearFeatures::FaceVertex& pair) noexcept {
    const Triangle& face = core_.triangles[pair.face];
    const Vec3 at_vertex = node(x_, pair.vertex);
    const ClosestPoint on_tool =
        closest_point_on_triangle(at_vertex, core_.corners[face[0]], core_.corners[face[1]], core_.corners[face[2]]);
    const int goes_on = core_.features->goes_on[pair.face];
    if (on_tool.feature == ClosestPoint::Feature::edge && !(goes_on >> on_tool.feature_index & 1)) return;
    if (on_tool.feature == ClosestPoint::Feature::vertex && !(goes_on >> (3 + on_tool.feature_index) & 1)) return;
    if (on_tool.distance_sq > limit_ * limit_) return;
    const auto fan = patch_.topology.triangles_of(pair.vertex);
    Vec3 outward = Vec3::Zero();
    ClosestPoint first;
    bool is_vertex = true;
    for (const int t : fan) {
      const ClosestPoint at = closest(patch_, x_, t, on_tool.point);
      if (t == fan[0]) first = at;
      is_vertex = is_vertex && at.feature == ClosestPoint::Feature::vertex &&
                  patch_.triangles[t][at.feature_index] == pair.vertex;
      if (!is_vertex) break;
      outward += face_normal(patch_, x_, t);
    }
    if (is_vertex) return add_at(on_tool.point, fan[0], first, outward);
    for (const int t : fan) add(on_tool.point, t);
  }

  void visit(const NearFeatures::CornerFace& pair) noexcept { add(core_.corners[pair.corner], pair.triangle); }

 private:
  template <class Pair>
  void note(std::vector<Pair>& list, const Pair& pair, NearFeatures& near) noexcept {
    if (list.size() < list.capacity()) return list.push_back(pair);
    visit(pair);
    near.is_known = false;
  }

  void add_at(const Vec3& place, int triangle, const ClosestPoint& at, const Vec3& outward) noexcept {
    if (at.distance_sq > limit_ * limit_) return;
    if (const auto contact = make_sphere_contact(patch_, x_, place, radius_, triangle, at, outward)) add(*contact);
  }

  void add(const Contact& contact) noexcept {
    const Apart& apart = patch_.is_curved ? kCurved : kFlat;
    const double first_sq =
        (corner_of(patch_, x_, contact.triangle, 1) - corner_of(patch_, x_, contact.triangle, 0)).squaredNorm();
    add_apart(out_, contact, apart.spacing * apart.spacing * first_sq, apart.along);
  }

  const SurfacePatch& patch_;
  const VectorX& x_;
  const ToolCore& core_;
  double radius_, margin_, limit_;
  ContactSet& out_;
};

/// A corner of the tool that nothing is in front of may have gone through the surface near where the tool touched
/// before.
void add_corner_inside(const SurfacePatch& patch, const VectorX& x, const Vec3& corner, double radius, double deepest,
                       int start, ContactSet& out) noexcept {
  Contact inside = track_point_contact(patch, x, corner, start);
  constexpr double kOn = 1e-9;  // of the radius, as in find_sphere_contacts()
  if (!(inside.gap <= kOn * radius && inside.gap > -deepest)) return;
  inside.gap -= radius;
  inside.core = corner;
  out.add(inside);
}

/// The same for a tool that may have some depth, as one that is being pushed out: each corner, edge and side with each
/// triangle, also those within flat sides. Features alone tell less there: a box ended with its edges in the body.
void find_deep_contacts(const SurfacePatch& patch, const VectorX& x, const ToolCore& core, double radius, double limit,
                        double deepest, std::span<const int> candidates, int start, Search& search,
                        ContactSet& out) noexcept {
  const auto vertex = [&](int t, int c) { return corner_of(patch, x, t, c); };
  const auto box = [&](int t) { return grown(box_of(vertex(t, 0), vertex(t, 1), vertex(t, 2)), limit); };
  for (const Vec3& corner : core.corners) {
    const int before = out.count;
    for (const int t : candidates)
      if (holds(box(t), corner)) search.add(corner, t);
    if (out.count == before && start >= 0) add_corner_inside(patch, x, corner, radius, deepest, start, out);
  }
  for (const auto& [i, k] : core.edges) {
    const Vec3 &a = core.corners[i], &b = core.corners[k];
    for (const int t : candidates) {
      if (is_apart(box(t), a, b)) continue;
      for (int c = 0; c < 3; ++c) {
        const auto [s, u] = closest_parameters(a, b, vertex(t, c), vertex(t, c + 1));
        if (s > 0 && s < 1) search.add((1 - s) * a + s * b, t);
      }
    }
  }
  for (const Triangle& face : core.triangles) {
    const Vec3 &a = core.corners[face[0]], &b = core.corners[face[1]], &c = core.corners[face[2]];
    for (const int t : candidates) {
      if (kt::is_apart(box(t), box_of(a, b, c))) continue;
      for (const int v : patch.triangles[t]) {
        const ClosestPoint at = closest_point_on_triangle(node(x, v), a, b, c);
        if (at.feature == ClosestPoint::Feature::face) search.add(at.point, t);
      }
    }
  }
}

void find_near_contacts(const VectorX& x, const ToolCore& core, double radius, double margin, double deepest,
                        std::span<const int> candidates, int start, const SurfacePatch& patch, Search& search,
                        NearFeatures& near, ContactSet& out) noexcept {
  const double limit = radius + margin;
  Box body;
  if (!near.is_known) search.gather_vertices(candidates, near);
  if (!(search.is_still_near(near, body) && near.is_known)) {
    near.slack = margin;
    search.gather_pairs(candidates, limit + near.slack, body, near);
    for (const int v : near.vertices) node(near.x, v) = node(x, v);
  }
  const Box reached = grown(body, limit);
  auto pair = near.corner_faces.begin();
  for (const int k : core.features->corners) {
    const Vec3& corner = core.corners[k];
    const int before = out.count;
    for (; pair != near.corner_faces.end() && pair->corner == k; ++pair) search.visit(*pair);
    if (out.count == before && start >= 0 && holds(reached, corner))
      add_corner_inside(patch, x, corner, radius, deepest, start, out);
  }
  for (const auto& edges : near.edge_edges) search.visit(edges);
  for (const auto& place : near.face_vertices) search.visit(place);
}

}  // namespace

NearFeatures::NearFeatures(int num_facets, int num_vertices)
    : x(3 * num_vertices),
      is_candidate(static_cast<std::size_t>(num_facets)),
      is_seen(static_cast<std::size_t>(num_vertices)) {
  vertices.reserve(is_seen.size());
  corner_faces.reserve(kMostPairs);
  edge_edges.reserve(kMostPairs);
  face_vertices.reserve(kMostPairs);
}

void find_tool_contacts(const SurfacePatch& patch, const VectorX& x, const ToolCore& core, double radius, double margin,
                        std::span<const int> candidates, int start, NearFeatures& near, ContactSet& out,
                        const Vec3& way, double overlap) noexcept {
  if (core.edges.empty())
    return find_sphere_contacts(patch, x, core.corners[0], radius, margin, candidates, start, out, way, overlap);
  out.count = 0;
  const double limit = radius + margin, deepest = 2 * limit + way.norm() + overlap;
  Search search(patch, x, core, radius, margin, out);
  if (overlap > 0)
    find_deep_contacts(patch, x, core, radius, limit, deepest, candidates, start, search, out);
  else
    find_near_contacts(x, core, radius, margin, deepest, candidates, start, patch, search, near, out);
  // As find_sphere_contacts(): the order does not depend on how triangles are numbered.
  const auto key = [](const Contact& c) {
    return std::array{c.normal[0], c.normal[1], c.normal[2], c.core[0], c.core[1], c.core[2]};
  };
  std::sort(out.contacts.begin(), out.contacts.begin() + out.count,
            [&](const Contact& a, const Contact& b) { return key(a) < key(b); });
}

}  // namespace kt
