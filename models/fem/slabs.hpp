#pragma once
// Elements in slabs across the body, so that several threads can sum over them into shared nodes: nodes are numbered by
// their distance from one end (breadth first over the elements), and an element spans at most two neighbouring
// distances. A slab holds the elements that begin in a range of distances and reaches into the first one of the next,
// so slabs 0, 2, 4 ... share no node, nor do 1, 3, 5 ...  Sums come in the same order whatever the number of threads.
#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

namespace kt {

struct Slabs {
  std::vector<int> elements;  ///< ordered slab after slab
  std::vector<int> begin;     ///< of each slab in `elements`, and the end
  int count() const { return static_cast<int>(begin.size()) - 1; }
};

/// Distance of every node from the first node of its component, breadth first; components follow one another.
template <int N>
std::vector<int> breadth_first_levels(int num_nodes, const std::vector<std::array<int, N>>& elements) {
  std::vector<std::vector<int>> touching(static_cast<std::size_t>(num_nodes));
  for (std::size_t e = 0; e < elements.size(); ++e)
    for (int a : elements[e]) touching[a].push_back(static_cast<int>(e));
  std::vector<int> level(static_cast<std::size_t>(num_nodes), -1), queue;
  const auto walk = [&](int start, int first_level) {
    queue.assign(1, start);
    level[start] = first_level;
    for (std::size_t i = 0; i < queue.size(); ++i)
      for (int e : touching[queue[i]])
        for (int b : elements[e])
          if (level[b] < 0) {
            level[b] = level[queue[i]] + 1;
            queue.push_back(b);
          }
  };
  int next_level = 0;
  for (int start = 0; start < num_nodes; ++start) {
    if (level[start] >= 0) continue;
    walk(start, next_level);
    const int far = queue.back();  // start again from the far end: longer and thinner slabs
    for (int node : queue) level[node] = -1;
    walk(far, next_level);
    next_level = level[queue.back()] + 1;
  }
  return level;
}

template <int N>
Slabs make_slabs(int num_nodes, const std::vector<std::array<int, N>>& elements) {
  constexpr std::size_t kFewest = 200;  // elements: less is not worth a task
  const std::vector<int> level = breadth_first_levels<N>(num_nodes, elements);
  std::vector<int> lowest;
  for (const auto& nodes : elements) {
    int low = level[nodes[0]];
    for (int a : nodes) low = std::min(low, level[a]);
    lowest.push_back(low);
  }
  Slabs out;
  out.elements.resize(elements.size());
  std::iota(out.elements.begin(), out.elements.end(), 0);
  std::stable_sort(out.elements.begin(), out.elements.end(), [&](int a, int b) { return lowest[a] < lowest[b]; });
  out.begin.push_back(0);
  for (std::size_t i = 1; i < out.elements.size(); ++i)
    if (lowest[out.elements[i]] != lowest[out.elements[i - 1]] &&
        i - static_cast<std::size_t>(out.begin.back()) >= kFewest)
      out.begin.push_back(static_cast<int>(i));
  out.begin.push_back(static_cast<int>(out.elements.size()));
  return out;
}

}  // namespace kt
