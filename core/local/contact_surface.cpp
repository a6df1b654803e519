#include "core/local/contact_surface.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "core/base/error.hpp"
#include "core/local/subdivision.hpp"

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

ContactSurface make_contact_surface(const SurfacePatch& patch, const Smoothing& smoothing) {
  require_backend("contact.surface", smoothing.scheme, contact_surface_backends());
  ContactSurface out;
  out.levels = smoothing.scheme == "flat" ? 0 : smoothing.levels;
  out.num_nodes = patch.num_vertices();
  if (out.levels == 0) out.facets = patch;
  std::vector<std::array<bool, 3>> sharp;
  for (const auto& c : patch.crease)
    sharp.push_back({c[0] != Crease::none, c[1] != Crease::none, c[2] != Crease::none});
  sharp.resize(patch.triangles.size());
  const Subdivision fine =
      out.levels == 0 ? make_flat(patch) : subdivide_loop(patch.triangles, patch.num_vertices(), sharp, out.levels);
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
  out.first_moved.push_back(0);
  for (const Triangle& t : fine.triangles) {
    std::map<int, Vec3> moved;
    for (int c = 0; c < 3; ++c)
      for (int k = fine.first[t[c]]; k < fine.first[t[c] + 1]; ++k)
        moved.try_emplace(fine.from[k], Vec3::Zero()).first->second[c] += fine.weight[k];
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

namespace {

Vec3 weighted_sum(const ContactSurface& surface, const VectorX& patch, int vertex) noexcept {
  Vec3 sum = Vec3::Zero();
  for (int k = surface.first[vertex]; k < surface.first[vertex + 1]; ++k)
    sum += surface.weight[k] * node(patch, surface.from[k]);
  return sum;
}

}  // namespace

void ContactSurface::follow(const VectorX& patch, VectorX& out) const noexcept {
  if (levels == 0) {
    if (out.size() < patch.size()) out.resize(patch.size());
    out.head(patch.size()) = patch;
    return;
  }
  const int end = apron_vertices >= 0 ? apron_vertices : static_cast<int>(first.size()) - 1;
  for (int v = 0; v < end; ++v) node(out, v) = weighted_sum(*this, patch, v);
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
  return is_apron(facet) ? bary : kt::weights_in_triangle(piece(facet), levels, bary);
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
  NodeWeights out = moved_by(facet, bary);
  for (int k = 0; k < out.count; ++k) out.node[k] = patch.global_node[out.node[k]];
  return out;
}

NodeWeights moved_by(const Surface& surface, const Smoothing& smoothing, int triangle, const Vec3& bary) {
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
