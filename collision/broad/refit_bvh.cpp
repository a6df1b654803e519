// A hierarchy of our own over the swept boxes, made for following a body: built once, then refitted as a whole or only
// above the few vertices that moved, in a time that grows with their number and the depth of the tree.
// Bounds are those of VertexBounds.
#include <algorithm>
#include <array>

#include "collision/broad/triangle_index.hpp"
#include "collision/broad/vertex_bounds.hpp"
#include "collision/broad/wide_tree.hpp"
#include "core/base/error.hpp"

namespace kt {
namespace {

constexpr int kSides = kBoundSides;
constexpr int kAhead = 16;        // triangles: how early a vertex is asked for that may not be in the cache
constexpr int kPartialShare = 8;  // with more than one in so many vertices moving, all of them are as fast

void prefetch([[maybe_unused]] const void* address) {
#ifdef __GNUC__
  __builtin_prefetch(address);  // halves a refit of a million triangles
#endif
}

/// The bounds of a node's children side by side.
struct alignas(16) Node {
  std::array<std::array<float, kTreeWidth>, kSides> side;
  std::array<int, kTreeWidth> child;
};

class RefitBvh final : public TriangleIndex {
 public:
  void build(std::span<const Triangle> triangles, const VectorX& x) override {
    triangles_.assign(triangles.begin(), triangles.end());
    std::vector<Box> boxes(triangles_.size());
    for (std::size_t t = 0; t < triangles_.size(); ++t) boxes[t] = swept_box(triangles_[t], x, x);
    adopt(make_wide_tree(boxes));
    bounds_.adopt(x);
    adopt_slots();
    refit(x, x);
  }

  void refit(const VectorX& x_t0, const VectorX& x_t1) noexcept override {
    bounds_.fit(x_t0, x_t1);
    const Triangle* next = in_slot_order_.data() + in_slot_order_.size();
    for (int i = static_cast<int>(nodes_.size()) - 1; i >= 0; --i) {  // children come after their parents
      Node& n = nodes_[i];
      for (int k = kTreeWidth - 1; k >= 0; --k)
        if (n.child[k] < 0) {
          if (next - in_slot_order_.data() > kAhead)
            for (const int v : next[-kAhead]) prefetch(&bounds_.of(v));
          write(n, k, bounds_.of(*--next));
        }
      if (i > 0) write(nodes_[places_[i].parent], places_[i].slot, bound_of(n));
    }
  }

  void refit_moved(std::span<const int> vertices, const VectorX& x_t0, const VectorX& x_t1) noexcept override {
    if (vertices.size() * kPartialShare > static_cast<std::size_t>(bounds_.size())) return refit(x_t0, x_t1);
    for (const int v : vertices) bounds_.fit(v, x_t0, x_t1);
    for (const int v : vertices)
      for (int s = first_slot_[v]; s < first_slot_[v + 1]; ++s) {
        const int i = slots_[s] / kTreeWidth, k = slots_[s] % kTreeWidth;
        if (update(i, k, bounds_.of(triangles_[~nodes_[i].child[k]]))) mark(i);
      }
    // Upward, level by level: every node at most once, and no further than bounds change.
    for (int level = static_cast<int>(num_marked_.size()) - 1; level >= 0; --level) {
      const int* marked = &marked_[level_begin_[level]];
      for (int j = 0; j < num_marked_[level]; ++j) {
        const Place& place = places_[marked[j]];
        is_marked_[marked[j]] = 0;
        if (level > 0 && update(place.parent, place.slot, bound_of(nodes_[marked[j]]))) mark(place.parent);
      }
      num_marked_[level] = 0;
    }
  }

  int candidates(const ToolSweep& sweep, double margin, std::span<int> out) const noexcept override {
    const Box path = path_box(sweep, margin);
    const Bound far = bounds_.farthest_sides(path);
    std::array<int, (kTreeWidth - 1) * kMaxTreeLevels + 1> stack;
    int depth = 0, found = 0;
    for (stack[depth++] = 0; depth > 0;) {
      const Node& node = nodes_[stack[--depth]];
      std::array<int, kTreeWidth> apart{};
      for (int s = 0; s < kSides; ++s)
        for (int k = 0; k < kTreeWidth; ++k) apart[k] |= node.side[s][k] > far.side[s];
      for (int k = 0; k < kTreeWidth; ++k) {
        if (apart[k]) continue;
        const int child = node.child[k];
        if (child > 0) stack[depth++] = child;
        if (child < 0 && !is_apart(bounds_.exact(triangles_[~child]), path)) out[found++] = ~child;
      }
    }
    std::sort(out.begin(), out.begin() + found);
    return found;
  }

 private:
  struct Place {
    int parent, slot, level;
  };

  void adopt(const WideTree& tree) {
    const auto n = static_cast<std::size_t>(tree.num_nodes());
    constexpr float kNone = std::numeric_limits<float>::infinity();  // in a union it is nothing
    nodes_.assign(n, {});
    places_.assign(n, {});
    for (std::size_t i = 0; i < n; ++i) {
      for (auto& side : nodes_[i].side) side.fill(kNone);
      std::copy_n(&tree.child[kTreeWidth * i], kTreeWidth, nodes_[i].child.begin());
    }
    for (int level = 0; level < tree.num_levels(); ++level)
      for (int i = tree.level_begin[level]; i < tree.level_begin[level + 1]; ++i)
        places_[i] = {tree.parent_slot[i] / kTreeWidth, tree.parent_slot[i] % kTreeWidth, level};
    level_begin_ = tree.level_begin;
    marked_.assign(n, 0);
    is_marked_.assign(n, 0);
    num_marked_.assign(static_cast<std::size_t>(tree.num_levels()), 0);
  }

  /// The slots of each vertex's triangles.
  void adopt_slots() {
    const auto n = static_cast<std::size_t>(bounds_.size());
    first_slot_.assign(n + 1, 0);
    for (const Triangle& t : triangles_)
      for (const int v : t) ++first_slot_[v + 1];
    for (std::size_t v = 0; v < n; ++v) first_slot_[v + 1] += first_slot_[v];
    slots_.assign(3 * triangles_.size(), 0);
    std::vector<int> next(first_slot_.begin(), first_slot_.end());
    in_slot_order_.clear();
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      for (int k = 0; k < kTreeWidth; ++k)
        if (nodes_[i].child[k] < 0) {
          in_slot_order_.push_back(triangles_[~nodes_[i].child[k]]);
          for (const int v : in_slot_order_.back()) slots_[next[v]++] = kTreeWidth * static_cast<int>(i) + k;
        }
  }

  static Bound bound_of(const Node& n) noexcept {
    Bound out;
    for (int s = 0; s < kSides; ++s)
      out.side[s] = std::min(std::min(n.side[s][0], n.side[s][1]), std::min(n.side[s][2], n.side[s][3]));
    return out;
  }

  static void write(Node& n, int k, const Bound& bound) noexcept {
    for (int s = 0; s < kSides; ++s) n.side[s][k] = bound.side[s];
  }

  /// Whether that changes anything.
  bool update(int i, int k, const Bound& bound) noexcept {
    bool changed = false;
    for (int s = 0; s < kSides; ++s) changed |= nodes_[i].side[s][k] != bound.side[s];
    if (changed) write(nodes_[i], k, bound);
    return changed;
  }

  void mark(int i) noexcept {
    if (is_marked_[i]) return;
    is_marked_[i] = 1;
    const int level = places_[i].level;
    marked_[level_begin_[level] + num_marked_[level]++] = i;
  }

  std::vector<Triangle> triangles_, in_slot_order_;
  VertexBounds bounds_;
  std::vector<int> first_slot_,
      slots_;                  // slots of the triangles of vertex v: slots_[first_slot_[v] .. first_slot_[v + 1])
  std::vector<Node> nodes_;    // level by level
  std::vector<Place> places_;  // of each node
  std::vector<int> level_begin_;
  std::vector<int> marked_, num_marked_;  // nodes to look at again: at most level_begin_'s numbers, per level
  std::vector<unsigned char> is_marked_;
};

}  // namespace

std::unique_ptr<TriangleIndex> make_refit_bvh_triangle_index() { return std::make_unique<RefitBvh>(); }

}  // namespace kt
