#include "collision/broad/surface_pairs.hpp"

#include <algorithm>

#include "core/base/parallel.hpp"

namespace kt {
namespace {

constexpr int kChunk = 256;  // vertices or edges that one thread takes at a time

/// Corners of the box around moving nodes: as a sweep, since the index compares with the box of that.
template <std::size_t N>
ToolSweep swept_box(const std::array<int, N>& nodes, const VectorX& x_t0, const VectorX& x_t1) {
  ToolSweep out{node(x_t0, nodes[0]), node(x_t0, nodes[0])};
  for (int i : nodes)
    for (const VectorX* x : {&x_t0, &x_t1}) {
      out.x_t0 = out.x_t0.cwiseMin(node(*x, i));
      out.x_t1 = out.x_t1.cwiseMax(node(*x, i));
    }
  return out;
}

bool within(const ToolSweep& a, const ToolSweep& b, double margin) {
  return ((a.x_t0 - b.x_t1).array() <= margin).all() && ((b.x_t0 - a.x_t1).array() <= margin).all();
}

}  // namespace

SurfacePairs::SurfacePairs(std::span<const Triangle> triangles, const VectorX& x, const std::string& backend)
    : triangles_(triangles.begin(), triangles.end()),
      index_(make_triangle_index(backend == "auto" ? "refit_bvh" : backend)) {
  for (const Triangle& t : triangles_) {
    vertices_.insert(vertices_.end(), t.begin(), t.end());
    for (int k = 0; k < 3; ++k) edges_.push_back({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
  }
  std::ranges::sort(vertices_);
  vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
  std::ranges::sort(edges_);
  edges_.erase(std::unique(edges_.begin(), edges_.end()), edges_.end());
  for (const Triangle& t : triangles_) {
    std::array<int, 3> of{};
    for (int k = 0; k < 3; ++k) {
      const std::array edge{std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])};
      of[k] = static_cast<int>(std::ranges::lower_bound(edges_, edge) - edges_.begin());
    }
    edges_of_.push_back(of);
  }
  index_->build(triangles_, x);
}

void SurfacePairs::find_around_vertex(int vertex, const VectorX& x_t0, const VectorX& x_t1, double margin,
                                      std::span<int> near, std::vector<SurfacePair>& out) const {
  const ToolSweep box = swept_box(std::array{vertex}, x_t0, x_t1);
  const int count = index_->candidates(box, margin, near);
  for (int t : near.first(static_cast<std::size_t>(count))) {
    const Triangle& v = triangles_[t];
    if (std::ranges::find(v, vertex) == v.end())
      out.push_back({SurfacePair::Kind::vertex_face, {vertex, v[0], v[1], v[2]}});
  }
}

void SurfacePairs::find_around_edge(int edge, const VectorX& x_t0, const VectorX& x_t1, double margin,
                                    std::span<int> near, std::vector<SurfacePair>& out) const {
  const std::array<int, 2>& a = edges_[edge];
  const ToolSweep box = swept_box(a, x_t0, x_t1);
  const int count = index_->candidates(box, margin, near);
  const std::size_t begin = out.size();
  for (int t : near.first(static_cast<std::size_t>(count)))
    for (int other : edges_of_[t]) {
      const std::array<int, 2>& b = edges_[other];
      if (other <= edge || a[0] == b[0] || a[0] == b[1] || a[1] == b[0] || a[1] == b[1]) continue;
      const SurfacePair pair{SurfacePair::Kind::edge_edge, {a[0], a[1], b[0], b[1]}};
      if (std::find(out.begin() + static_cast<std::ptrdiff_t>(begin), out.end(), pair) != out.end()) continue;
      if (within(box, swept_box(b, x_t0, x_t1), margin)) out.push_back(pair);
    }
}

const std::vector<SurfacePair>& SurfacePairs::find(const VectorX& x_t0, const VectorX& x_t1, double margin) {
  index_->refit(x_t0, x_t1);
  const int vertices = static_cast<int>(vertices_.size()), edges = static_cast<int>(edges_.size());
  const int vertex_chunks = (vertices + kChunk - 1) / kChunk, edge_chunks = (edges + kChunk - 1) / kChunk;
  std::vector<std::vector<SurfacePair>> found(static_cast<std::size_t>(vertex_chunks + edge_chunks));
  parallel_for(vertex_chunks + edge_chunks, [&](int chunk) {
    std::vector<int> near(triangles_.size());
    auto& out = found[static_cast<std::size_t>(chunk)];
    if (chunk < vertex_chunks)
      for (int i = chunk * kChunk; i < std::min(vertices, (chunk + 1) * kChunk); ++i)
        find_around_vertex(vertices_[i], x_t0, x_t1, margin, near, out);
    else
      for (int i = (chunk - vertex_chunks) * kChunk; i < std::min(edges, (chunk - vertex_chunks + 1) * kChunk); ++i)
        find_around_edge(i, x_t0, x_t1, margin, near, out);
  });
  pairs_.clear();
  for (const auto& part : found) pairs_.insert(pairs_.end(), part.begin(), part.end());
  return pairs_;
}

}  // namespace kt
