#include "core/contact_surface/contact_surface.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

#include "core/base/error.hpp"
#include "core/body/embedded_surface.hpp"
#include "core/body/node_weights.hpp"
#include "core/contact_surface/subdivision.hpp"

namespace kt {

std::vector<BackendInfo> contact_surface_backends() {
  return {{"flat", "the body's own triangles", true, ""},
          {"loop", "Loop's subdivision surface over them: smooth, sharp edges stay", true, ""}};
}

namespace {

Subdivision make_flat(const SurfacePatch& patch) {
  Subdivision out{patch.triangles, {0}, {}, {}};
  for (int v = 0; v < patch.num_vertices(); ++v) {
    out.from.push_back(v);
    out.weight.push_back(1);
    out.first.push_back(v + 1);
  }
  return out;
}

/// The triangles as they are, their vertices where their cells have them.
Subdivision make_embedded(const SurfacePatch& patch, ContactSurface& out) {
  out.is_embedded = true;
  out.facets = patch;
  out.facets.embedded.reset();
  out.facets.global_node = patch.embedded->global_vertex;
  out.facets.in_reach.assign(patch.embedded->global_vertex.size(), 1);
  return {patch.triangles, patch.embedded->first, patch.embedded->from, patch.embedded->weight};
}

/// Corners at grooves: the pieces inherit them, and which wall they are on follows.
void add_walls(const SurfacePatch& patch, int levels, SurfacePatch& fine) {
  if (patch.wall.empty()) return;
  if (levels == 0) {
    fine.wall = patch.wall;
    return;
  }
  std::vector<std::array<bool, 3>> groove(patch.triangles.size());
  for (std::size_t t = 0; t < groove.size(); ++t)
    for (int c = 0; c < 3; ++c) groove[t][c] = patch.crease[t][c] == Crease::groove;
  for (int i = 0; i < levels; ++i) {
    std::vector<std::array<bool, 3>> next;
    for (const auto& g : groove)
      next.insert(next.end(), {{g[0], false, g[2]}, {g[0], g[1], false}, {false, g[1], g[2]}, {false, false, false}});
    groove.swap(next);
  }
  fine.wall = number_walls(fine.triangles, groove, fine.topology);
}

}  // namespace

namespace {

/// The patch's triangles that are refined, in pieces. A triangle is refined where all that its pieces move with is in
/// the patch, away from its rim.
class Refined {
 public:
  Refined(const SurfacePatch& patch, ContactSurface& out) : patch_(patch), fine_(*out.fine), out_(out) {
    for (int v = 0; v < patch.num_vertices(); ++v) vertex_of_node_[patch.global_node[v]] = v;
  }

  void refine() {
    out_.fine_facet.assign(patch_.triangles.size(), -1);
    out_.facet_of_fine.assign(fine_.facets.size(), -1);
    for (std::size_t t = 0; t < patch_.triangles.size(); ++t) {
      const auto [begin, end] = std::ranges::equal_range(fine_.triangle, patch_.global_triangle[t]);
      const auto first = static_cast<int>(begin - fine_.triangle.begin()),
                 last = static_cast<int>(end - fine_.triangle.begin());
      if (first == last || patch_.on_rim[t] || !has_all_nodes(first, last)) continue;
      for (int f = first; f < last; ++f) place(f, static_cast<int>(t), f == first);
    }
    inherit_edges();
  }

 private:
  /// And no piece has more of them than NodeWeights can hold.
  bool has_all_nodes(int first, int last) const {
    for (int f = first; f < last; ++f) {
      std::set<int> body, yields;
      for (const int v : fine_.facets[f]) {
        for (int k = fine_.first[v]; k < fine_.first[v + 1]; ++k) {
          if (!vertex_of_node_.contains(fine_.node[k])) return false;
          body.insert(fine_.node[k]);
        }
        yields.insert(fine_.from.begin() + fine_.first_from[v], fine_.from.begin() + fine_.first_from[v + 1]);
      }
      if (body.size() + yields.size() > NodeWeights::kMost) return false;
    }
    return true;
  }

  int vertex(int fine) {
    const auto [found, is_new] = vertex_.try_emplace(fine, out_.facets.num_vertices());
    if (!is_new) return found->second;
    out_.facets.global_node.push_back(-1);
    out_.facets.in_reach.push_back(1);
    if (!fine_.is_place.empty()) {
      out_.is_place.resize(out_.facets.in_reach.size(), 0);
      out_.is_place.back() = fine_.is_place[static_cast<std::size_t>(fine)];
    }
    const auto follow = [&](int moving, double weight) {
      out_.from.push_back(moving);
      out_.weight.push_back(weight);
    };
    for (int k = fine_.first[fine]; k < fine_.first[fine + 1]; ++k)
      follow(vertex_of_node_.at(fine_.node[k]), fine_.weight[k]);
    for (int k = fine_.first_from[fine]; k < fine_.first_from[fine + 1]; ++k)
      follow(out_.num_nodes + fine_.from[k], fine_.share[k]);
    out_.first.push_back(static_cast<int>(out_.from.size()));
    return found->second;
  }

  void place(int fine, int triangle, bool in_its_place) {
    SurfacePatch& f = out_.facets;
    const Triangle& v = fine_.facets[fine];
    const Triangle facet{vertex(v[0]), vertex(v[1]), vertex(v[2])};
    int at = triangle;
    if (in_its_place) {
      f.triangles[at] = facet;
    } else {
      at = static_cast<int>(f.triangles.size());
      f.triangles.push_back(facet);
      f.global_triangle.push_back(patch_.global_triangle[triangle]);
      f.on_rim.push_back(patch_.on_rim[triangle]);
      out_.fine_facet.push_back(-1);
    }
    out_.fine_facet[at] = fine;
    out_.facet_of_fine[fine] = at;
    triangle_of_.resize(f.triangles.size(), -1);
    triangle_of_[at] = triangle;
  }

  /// Creases and walls of the triangles along whose edges pieces lie.
  void inherit_edges() {
    SurfacePatch& f = out_.facets;
    f.topology = make_topology(f.triangles, f.num_vertices());
    triangle_of_.resize(f.triangles.size(), -1);
    if (patch_.crease.empty()) return;
    std::vector<std::array<Crease, 3>> crease(f.triangles.size(), {Crease::none, Crease::none, Crease::none});
    std::vector<std::array<bool, 3>> groove(f.triangles.size(), {false, false, false});
    for (std::size_t i = 0; i < f.triangles.size(); ++i) {
      const int fine = i < out_.fine_facet.size() ? out_.fine_facet[i] : -1;
      for (int e = 0; e < 3; ++e) {
        if (fine < 0)
          crease[i][e] = patch_.crease[i][e];
        else if (const int edge = edge_of(fine, e); edge >= 0)
          crease[i][e] = patch_.crease[triangle_of_[i]][edge];
        groove[i][e] = crease[i][e] == Crease::groove;
      }
    }
    f.crease = std::move(crease);
    if (!patch_.wall.empty()) f.wall = number_walls(f.triangles, groove, f.topology);
  }

  /// The edge of its triangle that an edge of a piece lies on; -1: none.
  int edge_of(int fine, int e) const {
    constexpr double kOn = 1e-9;
    const Mat3& corners = fine_.corners[fine];
    for (int edge = 0; edge < 3; ++edge) {
      const int opposite = (edge + 2) % 3;
      if (corners(opposite, e) < kOn && corners(opposite, (e + 1) % 3) < kOn) return edge;
    }
    return -1;
  }

  const SurfacePatch& patch_;
  const FinePatch& fine_;
  ContactSurface& out_;
  std::map<int, int> vertex_of_node_, vertex_;  // of nodes of the body in the patch; of the fine patch's in the surface
  std::vector<int> triangle_of_;                // of each facet: of the patch, -1: it is one itself
};

}  // namespace

ContactSurface make_contact_surface(const SurfacePatch& patch, const Smoothing& smoothing,
                                    std::shared_ptr<const FinePatch> fine_patch) {
  require_backend("contact.surface", smoothing.scheme, contact_surface_backends());
  ContactSurface out;
  out.levels = smoothing.scheme == "flat" ? 0 : smoothing.levels;
  out.num_nodes = patch.num_vertices();
  if (patch.embedded && out.levels > 0)
    throw InputError(text("contact.surface ", smoothing.scheme, ": object.body lattice is touched at its own ",
                          "triangles: use flat"));
  if (out.levels == 0) out.facets = patch;
  std::vector<std::array<bool, 3>> sharp;
  for (const auto& c : patch.crease)
    sharp.push_back({c[0] != Crease::none, c[1] != Crease::none, c[2] != Crease::none});
  sharp.resize(patch.triangles.size());
  const Subdivision fine = patch.embedded    ? make_embedded(patch, out)
                           : out.levels == 0 ? make_flat(patch)
                                             : subdivide_loop(patch.triangles, patch.num_vertices(), sharp, out.levels);
  if (out.levels > 0) {
    SurfacePatch& f = out.facets;
    f.triangles = fine.triangles;
    f.is_curved = true;
    const int pieces = out.facets_per_triangle();
    for (std::size_t t = 0; t < fine.triangles.size(); ++t) {
      f.global_triangle.push_back(patch.global_triangle[t / pieces]);
      f.on_rim.push_back(patch.on_rim[t / pieces]);
    }
    f.global_node.assign(static_cast<std::size_t>(fine.num_vertices()), -1);
    f.topology = make_topology(f.triangles, fine.num_vertices());
    add_walls(patch, out.levels, f);
  }
  out.first = fine.first;
  out.from = fine.from;
  out.weight = fine.weight;
  if (fine_patch && out.levels == 0) {
    out.fine = std::move(fine_patch);
    Refined(patch, out).refine();
  }
  out.first_moved.push_back(0);
  for (const Triangle& t : out.facets.triangles) {
    std::map<int, Vec3> moved;
    for (int c = 0; c < 3; ++c)
      for (int k = out.first[t[c]]; k < out.first[t[c] + 1]; ++k)
        moved.try_emplace(out.from[k], Vec3::Zero()).first->second[c] += out.weight[k];
    if (moved.size() > NodeWeights::kMost)
      throw InputError(text("contact.surface ", smoothing.scheme, ": a point near node ",
                            patch.global_node[moved.begin()->first], " moves with ", moved.size(), " nodes, at most ",
                            NodeWeights::kMost, ": use flat"));
    for (const auto& [node, weight] : moved) {
      out.moved_node.push_back(node);
      out.moved_weight.push_back(weight);
    }
    out.first_moved.push_back(static_cast<int>(out.moved_node.size()));
  }
  return out;
}

void turn_offsets(const SurfacePatch& patch, const VectorX& x, ContactSurface& surface) {
  surface.offset.resize(0);
  if (!surface.fine || surface.fine->offsets.empty()) return;
  const FinePatch& fine = *surface.fine;
  const std::vector<Triangle>& facets = surface.facets.triangles;
  surface.offset.setZero(3 * static_cast<Eigen::Index>(surface.facets.num_vertices()));
  std::vector<int> vertex(static_cast<std::size_t>(fine.num_vertices()),
                          -1);  // of the surface; -1: at an edge, or none
  std::map<int, int> triangle;  // of the patch, of refined ones
  for (std::size_t f = 0; f < facets.size(); ++f) {
    if (surface.fine_facet[f] < 0) continue;
    for (std::size_t c = 0; c < 3; ++c)
      vertex[static_cast<std::size_t>(fine.facets[static_cast<std::size_t>(surface.fine_facet[f])][c])] = facets[f][c];
    if (f < patch.triangles.size()) triangle.emplace(patch.global_triangle[f], static_cast<int>(f));
  }
  for (std::size_t f = 0; f < facets.size(); ++f)
    for (std::size_t c = 0; surface.fine_facet[f] >= 0 && c < 3; ++c)
      if (surface.facets.topology.across[f][c] < 0)
        for (const std::size_t end : {c, (c + 1) % 3})
          vertex[static_cast<std::size_t>(fine.facets[static_cast<std::size_t>(surface.fine_facet[f])][end])] = -1;
  for (const VertexOffset& o : fine.offsets)  // one whose other fan is not refined is at an edge, too
    if (!triangle.contains(o.triangle)) vertex[static_cast<std::size_t>(o.vertex)] = -1;
  for (const VertexOffset& o : fine.offsets) {
    const int v = vertex[static_cast<std::size_t>(o.vertex)];
    if (v < 0) continue;
    const Triangle& t = patch.triangles[static_cast<std::size_t>(triangle.at(o.triangle))];
    node(surface.offset, v) += triangle_frame(node(x, t[0]), node(x, t[1]), node(x, t[2])) * o.along;
  }
}

namespace {

Vec3 weighted_sum(const ContactSurface& surface, const VectorX& patch, int vertex) noexcept {
  Vec3 sum = Vec3::Zero();
  for (int k = surface.first[vertex]; k < surface.first[vertex + 1]; ++k)
    sum += surface.weight[k] * node(patch, surface.from[k]);
  return sum;
}

}  // namespace

void ContactSurface::follow(const VectorX& patch, VectorX& out) const noexcept {
  const int end = apron_vertices >= 0 ? apron_vertices : static_cast<int>(first.size()) - 1;
  if (levels == 0 && !is_embedded) {
    const Eigen::Index own = 3 * static_cast<Eigen::Index>(num_nodes);
    if (out.size() < 3 * static_cast<Eigen::Index>(end)) out.resize(3 * static_cast<Eigen::Index>(end));
    out.head(own) = patch.head(own);
    for (int v = num_nodes; v < end; ++v) node(out, v) = weighted_sum(*this, patch, v);
    return;
  }
  for (int v = 0; v < end; ++v) node(out, v) = weighted_sum(*this, patch, v);
}

void ContactSurface::place(const VectorX& patch, VectorX& out) const noexcept {
  follow(patch, out);
  out.head(offset.size()) += offset;
}

void ContactSurface::follow_apron(const VectorX& patch, VectorX& out) const noexcept {
  if (apron_vertices < 0) return;
  std::array<Vec3, kMostApronSites> means;
  for (std::size_t s = 0; s < apron_means.size(); ++s) means[s] = apron_means[s].of(patch);
  for (std::size_t i = 0; i < apron.size(); ++i) {
    const ApronVertex& a = apron[i];
    const int v = apron_vertices + static_cast<int>(i);
    if (a.site >= 0)
      node(out, v) = means[static_cast<std::size_t>(a.site)];
    else if (a.patch_vertex >= 0)
      node(out, v) = node(patch, a.patch_vertex);
    else
      node(out, v).setZero();
  }
}

void ContactSurface::place_apron(const VectorX& patch, VectorX& out) const noexcept {
  follow_apron(patch, out);
  if (apron_vertices < 0) return;
  const Eigen::Index count = 3 * (static_cast<Eigen::Index>(first.size()) - 1 - apron_vertices);
  out.segment(3 * apron_vertices, count) += apron_offset.head(count);
}

Vec3 ContactSurface::weights_in_triangle(int facet, const Vec3& bary) const noexcept {
  if (is_apron(facet)) return bary;
  if (fine) return fine_facet[facet] < 0 ? bary : Vec3(fine->corners[fine_facet[facet]] * bary);
  return kt::weights_in_triangle(piece(facet), levels, bary);
}

std::pair<int, Vec3> ContactSurface::facet_at(int triangle, const SurfacePlace& place) const noexcept {
  if (levels > 0) {
    const auto [piece, bary] = piece_at(levels, place.weights);
    return {triangle * facets_per_triangle() + piece, bary};
  }
  if (!fine || fine_facet[triangle] < 0) return {triangle, place.weights};
  const auto [facet, bary] = fine->find(place);
  return {facet_of_fine[facet], bary};
}

Vec3 ContactSurface::at(const VectorX& patch, int facet, const Vec3& bary) const noexcept {
  Vec3 sum = Vec3::Zero();
  for (int k = first_moved[facet]; k < first_moved[facet + 1]; ++k)
    sum += bary.dot(moved_weight[k]) * node(patch, moved_node[k]);
  return sum;
}

void ContactSurface::add_at(VectorX& patch, int facet, const Vec3& bary, const Vec3& value) const noexcept {
  for (int k = first_moved[facet]; k < first_moved[facet + 1]; ++k)
    node(patch, moved_node[k]) += bary.dot(moved_weight[k]) * value;
}

void couple_points(const MatrixX& C, std::span<const NodeWeights> points, CouplingRoom& room,
                   Eigen::Ref<MatrixX> out) noexcept {
  std::ranges::fill(room.point, -1);
  for (int i = 0; i < static_cast<int>(points.size()); ++i) {
    const NodeWeights& own = points[i];
    const auto with = [&](int vertex) -> const Mat3& {
      Mat3& sum = room.sum[vertex];
      if (std::exchange(room.point[vertex], i) == i) return sum;
      sum.setZero();
      for (int a = 0; a < own.count; ++a) sum += own.weight[a] * C.block<3, 3>(3 * own.node[a], 3 * vertex);
      return sum;
    };
    for (int k = 0; k <= i; ++k) {
      Mat3 block = Mat3::Zero();
      for (int b = 0; b < points[k].count; ++b) block += points[k].weight[b] * with(points[k].node[b]);
      out.block<3, 3>(3 * i, 3 * k) = block;
      out.block<3, 3>(3 * k, 3 * i) = block.transpose();
    }
  }
}

NodeWeights ContactSurface::moved_by(int facet, const Vec3& bary) const noexcept {
  NodeWeights out;
  for (int k = first_moved[facet]; k < first_moved[facet + 1]; ++k) out.add(moved_node[k], bary.dot(moved_weight[k]));
  return out;
}

NodeWeights ContactSurface::moved_by(const SurfacePatch& patch, int facet, const Vec3& bary) const noexcept {
  if (goes_with_apron(facet)) {
    const Triangle& v = facets.triangles[facet];
    return {{facets.global_node[v[0]], facets.global_node[v[1]], facets.global_node[v[2]]}, bary};
  }
  const NodeWeights moving = moved_by(facet, bary);
  NodeWeights out;
  for (int k = 0; k < moving.count; ++k)
    if (moving.node[k] < num_nodes) out.add(patch.global_node[moving.node[k]], moving.weight[k]);
  return out;
}

NodeWeights moved_by(const Surface& surface, const Smoothing& smoothing, int triangle, const Vec3& bary) {
  if (surface.embedded) return surface.embedded->moved_by(surface.triangles[triangle], bary);
  if (smoothing.levels == 0) return {surface.triangles[triangle], bary};
  const VectorX nowhere = VectorX::Constant(3 * static_cast<Eigen::Index>(surface.topology.first.size()), 1e300);
  const SurfacePatch patch = make_patch(surface, nowhere, {Vec3::Zero(), triangle, 0});  // the triangle and its ring
  const ContactSurface smooth = make_contact_surface(patch, smoothing);
  const auto local = std::ranges::find(patch.global_triangle, triangle) - patch.global_triangle.begin();
  const auto [piece, weights] = piece_at(smooth.levels, bary);
  return smooth.moved_by(patch, static_cast<int>(local) * smooth.facets_per_triangle() + piece, weights);
}

Vec3 weights_in_triangle(int piece, int levels, const Vec3& bary) {
  Vec3 w = bary;
  for (int i = 0; i < levels; ++i, piece /= 4) {
    const Vec3 half = 0.5 * w;
    switch (piece % 4) {
      case 0:
        w = {w[0] + half[1] + half[2], half[1], half[2]};
        break;
      case 1:
        w = {half[0], w[1] + half[0] + half[2], half[2]};
        break;
      case 2:
        w = {half[0], half[1], w[2] + half[0] + half[1]};
        break;
      default:
        w = {half[0] + half[2], half[0] + half[1], half[1] + half[2]};
    }
  }
  return w;
}

std::pair<int, Vec3> piece_at(int levels, const Vec3& bary) {
  int piece = 0;
  Vec3 w = bary;
  for (int i = 0; i < levels; ++i) {
    piece *= 4;
    int corner = 3;
    for (int c = 0; c < 3; ++c)
      if (w[c] >= 0.5) corner = c;
    if (corner == 3) {
      w = Vec3(1 - 2 * w[2], 1 - 2 * w[0], 1 - 2 * w[1]);
      piece += 3;
      continue;
    }
    w *= 2;
    w[corner] -= 1;
    piece += corner;
  }
  return {piece, w};
}

}  // namespace kt
