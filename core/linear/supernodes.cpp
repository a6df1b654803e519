#include "core/linear/supernodes.hpp"

#include <Eigen/OrderingMethods>
#include <algorithm>
#include <numeric>

namespace kt {

NodeNeighbours node_neighbours(const SparseMatrix& matrix) {
  const int nodes = static_cast<int>(matrix.cols()) / 3;
  NodeNeighbours out;
  out.begin.assign(static_cast<std::size_t>(nodes) + 1, 0);
  const auto for_each_pair = [&](const auto& visit) {
    for (int c = 0; c < nodes; ++c)
      for (int k = matrix.outerIndexPtr()[3 * c]; k < matrix.outerIndexPtr()[3 * c + 1]; k += 3)
        if (const int r = matrix.innerIndexPtr()[k] / 3; r > c) visit(r, c);
  };
  for_each_pair([&](int a, int b) { ++out.begin[a + 1], ++out.begin[b + 1]; });
  std::partial_sum(out.begin.begin(), out.begin.end(), out.begin.begin());
  out.neighbour.resize(static_cast<std::size_t>(out.begin.back()));
  std::vector<int> next = out.begin;
  for_each_pair([&](int a, int b) { out.neighbour[next[a]++] = b, out.neighbour[next[b]++] = a; });
  return out;
}

namespace {

/// Approximate minimum degree of the nodes that are not `last`, among one another; then these.
std::vector<int> fill_reducing_order(const NodeNeighbours& graph, const std::vector<int>& last) {
  const int n = graph.size();
  std::vector<char> is_last(static_cast<std::size_t>(n), 0);
  for (int i : last) is_last[i] = 1;
  std::vector<int> others, number(static_cast<std::size_t>(n), -1);
  for (int i = 0; i < n; ++i)
    if (!is_last[i]) {
      number[i] = static_cast<int>(others.size());
      others.push_back(i);
    }
  std::vector<int> order;
  if (!others.empty()) {
    const int m = static_cast<int>(others.size());
    std::vector<int> begin{0}, rows;
    for (int i : others) {
      rows.push_back(number[i]);
      for (int k = graph.begin[i]; k < graph.begin[i + 1]; ++k)
        if (number[graph.neighbour[k]] >= 0) rows.push_back(number[graph.neighbour[k]]);
      std::sort(rows.begin() + begin.back(), rows.end());
      begin.push_back(static_cast<int>(rows.size()));
    }
    const std::vector<double> ones(rows.size(), 1.0);
    const SparseMatrix pattern = Eigen::Map<const SparseMatrix>(m, m, static_cast<Eigen::Index>(rows.size()),
                                                                begin.data(), rows.data(), ones.data());
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
    Eigen::AMDOrdering<int>()(pattern.selfadjointView<Eigen::Lower>(), permutation);
    for (int k = 0; k < m; ++k) order.push_back(others[permutation.indices()[k]]);
  }
  for (int i = 0; i < n; ++i)
    if (is_last[i]) order.push_back(i);
  return order;
}

std::vector<int> inverse_of(const std::vector<int>& order) {
  std::vector<int> place(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) place[order[k]] = static_cast<int>(k);
  return place;
}

/// Of every column of the factor: the first row below its diagonal; -1: none.
std::vector<int> elimination_tree(const NodeNeighbours& graph, const std::vector<int>& order) {
  const std::vector<int> place = inverse_of(order);
  std::vector<int> parent(order.size(), -1), ancestor(order.size(), -1);
  for (int j = 0; j < static_cast<int>(order.size()); ++j)
    for (int k = graph.begin[order[j]]; k < graph.begin[order[j] + 1]; ++k)
      for (int i = place[graph.neighbour[k]]; i >= 0 && i < j;) {
        const int next = ancestor[i];
        ancestor[i] = j;
        if (next < 0) parent[i] = j;
        i = next;
      }
  return parent;
}

/// Rows below the diagonal of every column, ascending.
std::vector<std::vector<int>> factor_rows(const NodeNeighbours& graph, const std::vector<int>& order,
                                          const std::vector<int>& parent) {
  const std::vector<int> place = inverse_of(order);
  std::vector<std::vector<int>> rows(order.size());
  std::vector<std::vector<int>> children(order.size());
  std::vector<int> stamp(order.size(), -1);
  for (int j = 0; j < static_cast<int>(order.size()); ++j) {
    stamp[j] = j;
    const auto add = [&](int i) {
      if (i <= j || stamp[i] == j) return;
      stamp[i] = j;
      rows[j].push_back(i);
    };
    for (int k = graph.begin[order[j]]; k < graph.begin[order[j] + 1]; ++k) add(place[graph.neighbour[k]]);
    for (int c : children[j])
      for (int i : rows[c]) add(i);
    std::sort(rows[j].begin(), rows[j].end());
    if (parent[j] >= 0) children[parent[j]].push_back(j);
  }
  return rows;
}

/// Children before parents and next to them, of several the one with most rows last: that one can be merged.
std::vector<int> postorder(const std::vector<int>& parent, const std::vector<int>& heights) {
  const int n = static_cast<int>(parent.size());
  std::vector<std::vector<int>> children(static_cast<std::size_t>(n) + 1);
  for (int j = 0; j < n; ++j) children[parent[j] < 0 ? n : parent[j]].push_back(j);
  for (auto& list : children)
    std::stable_sort(list.begin(), list.end(), [&](int a, int b) { return heights[a] < heights[b]; });
  std::vector<int> out, stack{n}, next(static_cast<std::size_t>(n) + 1, 0);
  while (!stack.empty()) {
    const int j = stack.back();
    if (next[j] < static_cast<int>(children[j].size())) {
      stack.push_back(children[j][next[j]++]);
    } else {
      stack.pop_back();
      if (j < n) out.push_back(j);
    }
  }
  return out;
}

/// Columns that follow one another, some zeros among their rows.
struct Group {
  int first = 0, count = 0, below = 0;
  double zeros = 0;
  double entries() const { return count * (count + 1) / 2.0 + static_cast<double>(count) * below; }
};

bool worth_merging(const Group& merged) {
  const double share = merged.zeros / merged.entries();
  if (merged.count <= 2) return true;
  if (merged.count <= 5) return share < 0.8;
  if (merged.count <= 16) return share < 0.15;
  return share < 0.05;
}

std::vector<Group> merge_columns(const std::vector<std::vector<int>>& rows, const std::vector<int>& parent) {
  const int n = static_cast<int>(rows.size());
  std::vector<Group> groups;  // of equal rows
  for (int j = 0; j < n; ++j) {
    const int height = static_cast<int>(rows[j].size());
    if (j > 0 && parent[j - 1] == j && static_cast<int>(rows[j - 1].size()) == height + 1) {
      ++groups.back().count;
      groups.back().below = height;
    } else {
      groups.push_back({j, 1, height, 0});
    }
  }
  std::vector<Group> out;  // from the end
  for (auto g = groups.rbegin(); g != groups.rend(); ++g) {
    Group own = *g;
    while (!out.empty() && parent[own.first + own.count - 1] == out.back().first) {
      const Group& next = out.back();
      const double added = static_cast<double>(own.count) * (next.count + next.below - own.below);
      const Group merged{own.first, own.count + next.count, next.below, own.zeros + next.zeros + added};
      if (!worth_merging(merged)) break;
      own = merged;
      out.pop_back();
    }
    out.push_back(own);
  }
  std::reverse(out.begin(), out.end());
  return out;
}

void find_runs(std::vector<Supernode>& nodes, const std::vector<int>& supernode_of) {
  for (Supernode& s : nodes) {
    const int size = static_cast<int>(s.below.size());
    for (int from = 0; from < size;) {
      Supernode::Run run{supernode_of[s.below[from]], from, from, {}};
      const Supernode& target = nodes[run.target];
      while (run.to < size && supernode_of[s.below[run.to]] == run.target) ++run.to;
      auto at = target.below.begin();
      for (int i = from; i < size; ++i) {
        const int row = s.below[i];
        if (row < target.first + target.count) {
          run.rows.push_back(row - target.first);
        } else {
          at = std::lower_bound(at, target.below.end(), row);
          run.rows.push_back(target.count + static_cast<int>(at - target.below.begin()));
        }
      }
      from = run.to;
      s.runs.push_back(std::move(run));
    }
  }
}

}  // namespace

Supernodes find_supernodes(const NodeNeighbours& graph, const std::vector<int>& last) {
  Supernodes out;
  out.order = fill_reducing_order(graph, last);
  std::vector<int> parent = elimination_tree(graph, out.order);
  std::vector<std::vector<int>> rows = factor_rows(graph, out.order, parent);
  {
    std::vector<int> heights;
    for (const auto& r : rows) heights.push_back(static_cast<int>(r.size()));
    const std::vector<int> post = postorder(parent, heights), place = inverse_of(post);
    std::vector<int> order, parents;
    std::vector<std::vector<int>> moved;
    for (int j : post) {
      order.push_back(out.order[j]);
      parents.push_back(parent[j] < 0 ? -1 : place[parent[j]]);
      for (int& i : rows[j]) i = place[i];
      std::sort(rows[j].begin(), rows[j].end());
      moved.push_back(std::move(rows[j]));
    }
    out.order = std::move(order);
    parent = std::move(parents);
    rows = std::move(moved);
  }
  std::vector<int> supernode_of(out.order.size());
  for (const Group& g : merge_columns(rows, parent)) {
    for (int j = g.first; j < g.first + g.count; ++j) supernode_of[j] = static_cast<int>(out.nodes.size());
    out.nodes.push_back({g.first, g.count, rows[g.first + g.count - 1], {}});
    const double s = 3.0 * g.count, u = 3.0 * g.below;
    out.flops += s * s * s / 3 + s * s * u + s * u * u;
    out.entries += 9 * g.entries();
  }
  find_runs(out.nodes, supernode_of);
  return out;
}

}  // namespace kt
