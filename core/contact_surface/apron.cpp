#include "core/contact_surface/apron.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.hpp"
#include "core/body/node_weights.hpp"

namespace kt {
namespace {

constexpr std::size_t kMostInMean = 12;  // vertices: what a facet moves with has to fit into NodeWeights

/// Those that a tool in reach touches; of a patch that has none that can move, all that can.
std::vector<int> leading_vertices(const SurfacePatch& patch, std::span<const char> moves) {
  std::vector<int> in_reach, others;
  for (int v = 0; v < patch.num_vertices(); ++v)
    if (moves[v]) (patch.in_reach[v] ? in_reach : others).push_back(v);
  return in_reach.empty() ? others : in_reach;
}

std::vector<const ContactSite*> all_sites(const ContactSite& site) {
  std::vector<const ContactSite*> out{&site};
  for (const ContactSite& other : site.others) out.push_back(&other);
  if (out.size() > kMostApronSites) out.resize(kMostApronSites);
  return out;
}

double distance_from(const ContactSite& site, const Vec3& place) {
  const double way_sq = site.way.squaredNorm();
  const Vec3 away = place - site.centre;
  const double share = way_sq > 0 ? std::clamp(away.dot(site.way) / way_sq, 0.0, 1.0) : 0;
  return (away - share * site.way).norm();
}

int nearest_of(const Eigen::Matrix3Xd& places, const Vec3& place) {
  Eigen::Index nearest = 0;
  (places.colwise() - place).colwise().squaredNorm().minCoeff(&nearest);
  return static_cast<int>(nearest);
}

/// The place where the tool was, as wide as what it touched: a ball of radius R that is d deep presses as a uniform
/// pressure within 0.72 sqrt(R d) does (Johnson 1985, 3.4 and 4.2). Where the cells are larger, the point under it.
NodeWeights make_mean(const Surface& surface, const ContactSite& site, const SurfacePatch& patch,
                      const std::vector<int>& leading, const Eigen::Matrix3Xd& places, double depth,
                      const ApronOptions& options) {
  constexpr double kShallow = 0.1;  // of the radius: less deep than this is told by nothing
  const double r = options.radius, wide = 0.72 * std::sqrt(r * std::clamp(depth, kShallow * r, std::max(r, 0.0)));
  std::vector<std::pair<double, int>> close;
  for (std::size_t i = 0; i < leading.size(); ++i)
    if (const double d = (places.col(static_cast<Eigen::Index>(i)) - site.centre).norm(); d < wide)
      close.emplace_back(d, leading[i]);
  std::ranges::sort(close);
  if (close.size() > kMostInMean) close.resize(kMostInMean);
  NodeWeights out;
  if (close.size() >= 3) {
    for (const auto& [d, v] : close) out.add(v, 1 - d * d / (wide * wide));
  } else {
    const Triangle& corners = surface.triangles[site.triangle];
    for (const int i : corners) {
      const auto v = std::ranges::find_if(leading, [&](int own) { return patch.global_node[own] == i; });
      if (v == leading.end()) continue;
      const double d = (places.col(v - leading.begin()) - site.centre).norm();
      out.add(*v, 1 / (d + 1e-9));
    }
    if (out.count == 0) out.add(leading[static_cast<std::size_t>(nearest_of(places, site.centre))], 1);
  }
  double sum = 0;
  for (int k = 0; k < out.count; ++k) sum += out.weight[k];
  for (int k = 0; k < out.count; ++k) out.weight[k] /= sum;
  return out;
}

/// Of what the load moves the dent alone: less what it moves the patch by as a whole, as of a flap that is lifted, and
/// no deeper than the patch is wide, as an indefinite tangent would have it.
VectorX find_dents(const SurfacePatch& patch, const VectorX& unloaded, double deepest) {
  if (unloaded.size() == 0 || !unloaded.allFinite()) return {};
  Vec3 whole = Vec3::Zero();
  int count = 0;
  for (std::size_t t = 0; t < patch.triangles.size(); ++t) {
    if (!patch.on_rim[t]) continue;
    for (const int v : patch.triangles[t]) whole += node(unloaded, v);
    count += 3;
  }
  VectorX out = unloaded;
  if (count > 0) out -= (whole / count).replicate(patch.num_vertices(), 1);
  const double depth = out.reshaped(3, patch.num_vertices()).colwise().norm().maxCoeff();
  return depth > deepest && deepest > 0 ? VectorX(deepest / depth * out) : out;
}

}  // namespace

void ApronMotion::means(const VectorX& patch_x, std::span<Vec3> out) const noexcept {
  for (std::size_t s = 0; s < mean.size(); ++s) out[s] = mean[s].of(patch_x) - mean[s].of(patch_at);
}

Vec3 ApronMotion::place(int i, std::span<const Vec3> means) const noexcept {
  if (site[i] < 0) return node(at, i);
  return node(at, i) + means[static_cast<std::size_t>(site[i])];
}

ApronMotion make_apron_motion(const Surface& surface, const VectorX& x, const ContactSite& site,
                              const SurfacePatch& patch, const ApronOptions& options) {
  const auto n = static_cast<std::size_t>(x.size() / 3);
  ApronMotion out;
  out.patch_vertex.assign(n, -1);
  out.at = x;
  out.site.assign(n, -1);
  out.patch_at = options.patch_x;
  for (int v = 0; v < patch.num_vertices(); ++v)
    if (options.answers[v]) out.patch_vertex[patch.global_node[v]] = v;
  const std::vector<int> leading = leading_vertices(patch, options.moves);
  if (leading.empty()) return out;
  Eigen::Matrix3Xd places(3, static_cast<Eigen::Index>(leading.size()));
  for (std::size_t i = 0; i < leading.size(); ++i)
    places.col(static_cast<Eigen::Index>(i)) = node(out.patch_at, leading[i]);
  const std::vector<const ContactSite*> sites = all_sites(site);
  const VectorX dents = find_dents(patch, options.unloaded, site.reach);
  const bool is_loaded = dents.size() == out.patch_at.size();
  const auto unloaded = [&](int v) { return is_loaded ? Vec3(node(dents, v)) : Vec3(Vec3::Zero()); };

  std::vector<Vec3> mean_unloaded;
  for (const ContactSite* s : sites) {
    const int under = leading[static_cast<std::size_t>(nearest_of(places, s->centre))];
    out.mean.push_back(make_mean(surface, *s, patch, leading, places, unloaded(under).norm(), options));
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < out.mean.back().count; ++k)
      sum += out.mean.back().weight[k] * unloaded(out.mean.back().node[k]);
    mean_unloaded.push_back(sum);
  }
  for (int i = 0; i < static_cast<int>(n); ++i) {
    if (out.patch_vertex[i] >= 0 || options.is_fixed[i] || surface.topology.triangles_of(i).empty()) continue;
    const Vec3 place = node(x, i);
    std::size_t own = 0;
    for (std::size_t s = 1; s < sites.size(); ++s)
      if (distance_from(*sites[s], place) < distance_from(*sites[own], place)) own = s;
    out.site[i] = static_cast<signed char>(own);
    if (!is_loaded) continue;
    // What the load moved here fades with the distance from it, as on an elastic half space.
    const int near = nearest_of(places, place);
    const double there = distance_from(*sites[own], places.col(near)), here = distance_from(*sites[own], place);
    const Vec3 at_near = unloaded(leading[static_cast<std::size_t>(near)]);
    const Vec3 moved = (here > there ? Vec3(there / here * at_near) : at_near) - mean_unloaded[own];
    node(out.at, i) += moved;
    out.lowered = std::max(out.lowered, moved.norm());
  }
  return out;
}

ApronRoom::ApronRoom(int nodes, int triangles_at_most, int vertices_at_most, ContactSurface& out)
    : triangles(out.facets.triangles.size()),
      vertices(out.facets.global_node.size()),
      followed(out.from.size()),
      moved(out.moved_node.size()),
      most_triangles(triangles_at_most),
      most_vertices(vertices_at_most),
      vertex_of_node(static_cast<std::size_t>(nodes), -1) {
  const std::size_t t = triangles + static_cast<std::size_t>(most_triangles);
  const std::size_t v = vertices + static_cast<std::size_t>(most_vertices);
  const std::size_t weights = kMostInMean * static_cast<std::size_t>(most_vertices);
  SurfacePatch& f = out.facets;
  f.triangles.reserve(t);
  f.global_triangle.reserve(t);
  f.on_rim.reserve(t);
  f.global_node.reserve(v);
  f.in_reach.resize(vertices, 0);
  f.in_reach.reserve(v);
  if (!f.wall.empty()) f.wall.reserve(t);
  if (!f.crease.empty()) f.crease.reserve(t);
  f.topology.first.reserve(v + 1);
  f.topology.fan.reserve(3 * t);
  f.topology.across.reserve(t);
  topology.reserve(t, v);
  out.first.reserve(v + 1);
  out.from.reserve(followed + weights);
  out.weight.reserve(followed + weights);
  out.first_moved.reserve(t + 1);
  out.moved_node.reserve(moved + NodeWeights::kMost * static_cast<std::size_t>(most_triangles));
  out.moved_weight.reserve(out.moved_node.capacity());
  out.apron_facets = static_cast<int>(triangles);
  if (out.apron_vertices < 0) out.apron_vertices = static_cast<int>(vertices);
  out.apron.reserve(v - static_cast<std::size_t>(out.apron_vertices));
  out.apron_offset.conservativeResize(3 * static_cast<Eigen::Index>(out.apron.capacity()));
}

namespace {

void remove_apron(const ApronRoom& room, ContactSurface& out) noexcept {
  SurfacePatch& f = out.facets;
  f.triangles.resize(room.triangles);
  f.global_triangle.resize(room.triangles);
  f.on_rim.resize(room.triangles);
  f.global_node.resize(room.vertices);
  f.in_reach.resize(room.vertices);
  if (!f.wall.empty()) f.wall.resize(room.triangles);
  if (!f.crease.empty()) f.crease.resize(room.triangles);
  out.first.resize(room.vertices + 1);
  out.from.resize(room.followed);
  out.weight.resize(room.followed);
  out.first_moved.resize(room.triangles + 1);
  out.moved_node.resize(room.moved);
  out.moved_weight.resize(room.moved);
  out.apron.resize(room.vertices - static_cast<std::size_t>(out.apron_vertices));
}

/// A vertex of the apron for a node of the body: one of the patch's, as a smooth patch has others, or one of its own.
int add_vertex(const ApronMotion& motion, int global, ContactSurface& out) noexcept {
  const auto follow = [&](int vertex, double weight) {
    out.from.push_back(vertex);
    out.weight.push_back(weight);
  };
  const auto begin = out.from.size();
  ApronVertex& vertex = out.apron.emplace_back();
  if (const int v = motion.patch_vertex[global]; v >= 0) {
    follow(v, 1);
    vertex.patch_vertex = v;
  } else if (motion.site[global] >= 0) {
    vertex.site = motion.site[global];
    const NodeWeights& mean = motion.mean[static_cast<std::size_t>(vertex.site)];
    for (int k = 0; k < mean.count; ++k) follow(mean.node[k], mean.weight[k]);
  }
  out.first.push_back(static_cast<int>(out.from.size()));
  Vec3 offset = node(motion.at, global);
  for (std::size_t k = begin; k < out.from.size(); ++k) offset -= out.weight[k] * node(motion.patch_at, out.from[k]);
  const int added = out.facets.num_vertices();
  node(out.apron_offset, added - out.apron_vertices) = offset;
  out.facets.global_node.push_back(global);
  out.facets.in_reach.push_back(0);
  return added;
}

/// Who moves with the facet: the patch's vertices that its three follow, each once, ascending.
void add_moved(const Triangle& facet, ContactSurface& out) noexcept {
  std::array<std::pair<int, Vec3>, NodeWeights::kMost> moved;
  int count = 0;
  for (int c = 0; c < 3; ++c)
    for (int k = out.first[facet[c]]; k < out.first[facet[c] + 1]; ++k) {
      const auto end = moved.begin() + count;
      const auto known = std::find_if(moved.begin(), end, [&](const auto& m) { return m.first == out.from[k]; });
      if (known == end) {
        if (count == NodeWeights::kMost) continue;
        moved[static_cast<std::size_t>(count++)] = {out.from[k], Vec3::Zero()};
      }
      known->second[c] += out.weight[k];
    }
  std::sort(moved.begin(), moved.begin() + count, [](const auto& a, const auto& b) { return a.first < b.first; });
  for (int i = 0; i < count; ++i) {
    out.moved_node.push_back(moved[static_cast<std::size_t>(i)].first);
    out.moved_weight.push_back(moved[static_cast<std::size_t>(i)].second);
  }
  out.first_moved.push_back(static_cast<int>(out.moved_node.size()));
}

}  // namespace

void give_rim_to_apron(const ApronMotion& motion, const SurfacePatch& patch, ContactSurface& out) {
  out.apron_vertices = out.facets.num_vertices();
  if (out.levels > 0) return;
  std::vector<int> vertex(static_cast<std::size_t>(patch.num_vertices()));
  out.apron_offset.resize(3 * patch.num_vertices());
  for (int v = 0; v < patch.num_vertices(); ++v)
    vertex[v] = motion.patch_vertex[patch.global_node[v]] == v ? v : add_vertex(motion, patch.global_node[v], out);
  out.rim_of_apron.assign(out.facets.triangles.size(), 0);
  out.first_moved = {0};
  out.moved_node.clear();
  out.moved_weight.clear();
  for (std::size_t t = 0; t < out.facets.triangles.size(); ++t) {
    for (int& v : out.facets.triangles[t])
      if (v < patch.num_vertices()) v = vertex[v];
    out.rim_of_apron[t] = std::ranges::any_of(out.facets.triangles[t], [&](int v) { return v >= out.apron_vertices; });
    add_moved(out.facets.triangles[t], out);
  }
  out.facets.topology = make_topology(out.facets.triangles, out.facets.num_vertices());
}

void append_apron(const Surface& surface, const ApronMotion& motion, const SurfacePatch& patch,
                  std::span<const int> triangles, ApronRoom& room, ContactSurface& out) noexcept {
  remove_apron(room, out);
  SurfacePatch& facets = out.facets;
  if (out.apron_means.empty()) out.apron_means = motion.mean;  // the first time: no allocation later
  const bool shares = out.levels == 0;                         // a smooth patch has other vertices than its nodes
  if (shares)  // the rim's last: what of it is the apron's is used as that
    for (int v = 0; v < static_cast<int>(room.vertices); ++v)
      if (const int i = facets.global_node[v]; i >= 0) room.vertex_of_node[i] = v;
  const auto vertex = [&](int global) {
    int& known = room.vertex_of_node[global];
    if (known < 0) known = add_vertex(motion, global, out);
    return known;
  };
  for (const int t : triangles) {
    const Triangle& v = surface.triangles[t];
    const Triangle facet{vertex(v[0]), vertex(v[1]), vertex(v[2])};
    facets.triangles.push_back(facet);
    facets.global_triangle.push_back(t);
    facets.on_rim.push_back(1);
    if (!facets.wall.empty()) facets.wall.push_back(shares ? surface.wall[t] : std::array{0, 0, 0});
    if (!facets.crease.empty()) facets.crease.push_back(surface.crease[t]);
    add_moved(facet, out);
  }
  for (const int t : triangles)
    for (const int i : surface.triangles[t]) room.vertex_of_node[i] = -1;
  for (const int i : patch.global_node) room.vertex_of_node[i] = -1;
  make_topology(facets.triangles, facets.num_vertices(), room.topology, facets.topology);
}

}  // namespace kt
