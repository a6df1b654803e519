#include "collision/broad/wide_tree.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "core/base/error.hpp"

namespace kt {
namespace {

using Float3 = std::array<float, 3>;

constexpr float kFar = 1e18f;  // areas of boxes this large are still numbers
constexpr int kBins = 16;
constexpr int kFew = kTreeWidth * kTreeWidth;  // up to here full nodes are worth more than the best cut

/// A box in single precision: only where to cut depends on it.
struct Item {
  Float3 low, high;
  int triangle;
  float centre(int axis) const { return low[axis] + high[axis]; }  // twice the centre
};

struct Range {
  int begin, end, depth;
  int count() const { return end - begin; }
};

float near(double v) { return static_cast<float>(std::clamp<double>(v, -kFar, kFar)); }

struct Extent {
  Float3 low{kFar, kFar, kFar}, high{-kFar, -kFar, -kFar};
  void add(const Float3& l, const Float3& h) {
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], l[k]);
      high[k] = std::max(high[k], h[k]);
    }
  }
  float area() const {
    const float x = high[0] - low[0], y = high[1] - low[1], z = high[2] - low[2];
    return x * y + y * z + z * x;
  }
};

std::vector<Item> make_items(std::span<const Box> boxes) {
  // Relative to the first box, so that far from the origin floats still tell triangles apart.
  Vec3 origin = Vec3::Zero();
  for (const Box& b : boxes)
    if (b.low.allFinite() && b.high.allFinite()) {
      origin = b.low;
      break;
    }
  std::vector<Item> items(boxes.size());
  for (std::size_t t = 0; t < boxes.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      items[t].low[k] = near(boxes[t].low[k] - origin[k]);
      items[t].high[k] = near(boxes[t].high[k] - origin[k]);
      items[t].triangle = static_cast<int>(t);
    }
  return items;
}

/// Extent of the centres (twice as large).
Extent centres(std::span<const Item> items) {
  Extent out;
  out.low = {4 * kFar, 4 * kFar, 4 * kFar};
  out.high = {-4 * kFar, -4 * kFar, -4 * kFar};
  for (const Item& i : items) {
    const Float3 c{i.centre(0), i.centre(1), i.centre(2)};
    out.add(c, c);
  }
  return out;
}

int cut_by_count(std::span<Item> items, int axis, int at) {
  std::nth_element(items.begin(), items.begin() + at, items.end(), [axis](const Item& a, const Item& b) {
    return a.centre(axis) < b.centre(axis) || (a.centre(axis) == b.centre(axis) && a.triangle < b.triangle);
  });
  return at;
}

/// Cuts where the area of both sides times their number of triangles is least; 0 when no cut parts the centres.
int cut_by_area(std::span<Item> items, int axis, float low, float high) {
  const float scale = kBins / (high - low);
  if (!(scale > 0 && scale < 1 / std::numeric_limits<float>::min())) return 0;
  const auto bin_of = [&](const Item& i) {
    return std::min(kBins - 1, static_cast<int>((i.centre(axis) - low) * scale));
  };
  std::array<Extent, kBins> extent;
  std::array<int, kBins> count{};
  for (const Item& i : items) {
    const int b = bin_of(i);
    extent[b].add(i.low, i.high);
    ++count[b];
  }
  std::array<float, kBins> right{};  // cost of bins [b, end)
  Extent sum;
  for (int b = kBins - 1, n = 0; b > 0; --b) {
    n += count[b];
    if (count[b]) sum.add(extent[b].low, extent[b].high);
    right[b] = n ? sum.area() * static_cast<float>(n) : std::numeric_limits<float>::infinity();
  }
  sum = {};
  float least = std::numeric_limits<float>::infinity();
  int cut = 0;
  for (int b = 1, n = 0; b < kBins; ++b) {
    n += count[b - 1];
    if (count[b - 1]) sum.add(extent[b - 1].low, extent[b - 1].high);
    if (n == 0) continue;
    const float cost = sum.area() * static_cast<float>(n) + right[b];
    if (cost < least) {
      least = cost;
      cut = b;
    }
  }
  if (cut == 0) return 0;
  const auto middle = std::partition(items.begin(), items.end(), [&](const Item& i) { return bin_of(i) < cut; });
  return static_cast<int>(middle - items.begin());
}

/// Cuts a range of more than one node's triangles in two, neither empty; returns the size of the first.
int cut(std::span<Item> items, int depth) {
  const Extent c = centres(items);
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (c.high[k] - c.low[k] > c.high[axis] - c.low[axis]) axis = k;
  const auto n = static_cast<int>(items.size());
  if (n <= kFew) {
    const int nodes = (n + kTreeWidth - 1) / kTreeWidth;  // two or more
    return cut_by_count(items, axis, kTreeWidth * ((nodes + 1) / 2));
  }
  if (depth < kMaxCutDepth)
    if (const int at = cut_by_area(items, axis, c.low[axis], c.high[axis])) return at;
  return cut_by_count(items, axis, n / 2);
}

/// The ranges of a node's children: the most populous is cut until there are four, or none is worth a cut.
std::vector<Range> cut_into_children(std::vector<Item>& items, const Range& whole) {
  std::vector<Range> out{whole};
  while (out.size() < kTreeWidth) {
    auto largest =
        std::max_element(out.begin(), out.end(), [](const Range& a, const Range& b) { return a.count() < b.count(); });
    if (largest->count() <= kTreeWidth) break;
    const Range r = *largest;
    const int at = cut(std::span(items).subspan(r.begin, r.count()), r.depth);
    *largest = {r.begin, r.begin + at, r.depth + 1};
    out.insert(largest + 1, {r.begin + at, r.end, r.depth + 1});
  }
  return out;
}

}  // namespace

WideTree make_wide_tree(std::span<const Box> boxes) {
  std::vector<Item> items = make_items(boxes);
  WideTree tree;
  struct Pending {
    Range range;
    int parent_slot;
  };
  std::vector<Pending> level{{{0, static_cast<int>(items.size()), 0}, -1}}, next;
  for (; !level.empty(); level.swap(next), next.clear()) {
    tree.level_begin.push_back(tree.num_nodes());
    for (const Pending& p : level) {
      const int own = tree.num_nodes();
      tree.parent_slot.push_back(p.parent_slot);
      if (p.parent_slot >= 0) tree.child[p.parent_slot] = own;
      int slot = kTreeWidth * own;
      tree.child.resize(slot + kTreeWidth, WideTree::kEmpty);
      std::vector<Range> children = cut_into_children(items, p.range);
      int free = kTreeWidth - static_cast<int>(children.size());
      for (const Range& r : children) {
        if (r.count() - 1 > free) {
          next.push_back({r, slot++});
          continue;
        }
        // Few enough to sit here themselves.
        free -= r.count() - 1;
        for (int i = r.begin; i < r.end; ++i) tree.child[slot++] = ~items[i].triangle;
      }
    }
  }
  tree.level_begin.push_back(tree.num_nodes());
  KT_ASSERT(tree.num_levels() <= kMaxTreeLevels);
  return tree;
}

}  // namespace kt
