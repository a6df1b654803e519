#include "core/local/block_confinement.hpp"

#include <algorithm>

#include "core/base/wide.hpp"

namespace kt {
namespace {

/// to[at[i]] += weight[i] from, for whole groups of `Size` numbers.
template <int Size>
inline __attribute__((always_inline)) void spread_to(const double* from, const double* weight, const unsigned short* at,
                                                     int count, double* to) {
  for (int i = 0; i < count; ++i)
    for (int k = 0; k < Size; ++k) to[Size * at[i] + k] += weight[i] * from[k];
}
template <int Size>
inline __attribute__((always_inline)) void add_to(const double* from, double weight, const int* at,
                                                  std::ptrdiff_t count, double* to) {
  for (std::ptrdiff_t i = 0; i < count; ++i)
    for (int k = 0; k < Size; ++k) to[static_cast<std::ptrdiff_t>(Size) * at[i] + k] += weight * from[Size * i + k];
}

KT_WIDE void spread_18(const double* from, const double* weight, const unsigned short* at, int count, double* to) {
  spread_to<18>(from, weight, at, count, to);
}
KT_WIDE void add_18(const double* from, double weight, const int* at, std::ptrdiff_t count, double* to) {
  add_to<18>(from, weight, at, count, to);
}

template <int Size>
void transpose_blocks(const double* from, double* to) {
  for (int m = 0; m < Size; m += 9)
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) to[m + 3 * c + r] = from[m + 3 * r + c];
}

}  // namespace

BlockConfinement::BlockConfinement(const NodeBlocks& blocks, const Interpolation& interpolation) : p_(interpolation) {
  find_near(blocks);
  make_rows();
  find_slots();
}

void BlockConfinement::find_near(const NodeBlocks& blocks) {
  std::vector<int> stamp(p_.kept.size(), -1), at(p_.kept.size());
  near_begin_ = {0};
  for (int j = 0; j < blocks.num_nodes(); ++j) {
    const auto begin = static_cast<std::ptrdiff_t>(near_.size());
    for (int k = blocks.first(j); k < blocks.last(j); ++k)
      for (int e = p_.begin[blocks.neighbour(k)]; e < p_.begin[blocks.neighbour(k) + 1]; ++e)
        if (int& seen = stamp[p_.column[e]]; seen != j) {
          seen = j;
          near_.push_back(p_.column[e]);
        }
    std::sort(near_.begin() + begin, near_.end());
    for (auto k = begin; k < static_cast<std::ptrdiff_t>(near_.size()); ++k) at[near_[k]] = static_cast<int>(k - begin);
    near_begin_.push_back(static_cast<int>(near_.size()));
    for (int k = blocks.first(j); k < blocks.last(j); ++k)
      for (int e = p_.begin[blocks.neighbour(k)]; e < p_.begin[blocks.neighbour(k) + 1]; ++e)
        place_.push_back(static_cast<unsigned short>(at[p_.column[e]]));
  }
}

void BlockConfinement::make_rows() {
  std::vector<std::vector<int>> users(p_.kept.size());  // nodes that follow each kept one
  for (int j = 0; j + 1 < static_cast<int>(p_.begin.size()); ++j)
    for (int e = p_.begin[j]; e < p_.begin[j + 1]; ++e) users[p_.column[e]].push_back(j);
  std::vector<int> stamp(p_.kept.size(), -1);
  begin_ = {0};
  for (int b = 0; b < static_cast<int>(p_.kept.size()); ++b) {
    const auto begin = static_cast<std::ptrdiff_t>(rows_.size());
    for (int j : users[b])
      for (int k = near_begin_[j]; k < near_begin_[j + 1]; ++k)
        if (near_[k] >= b && stamp[near_[k]] != b) {
          stamp[near_[k]] = b;
          rows_.push_back(near_[k]);
        }
    std::sort(rows_.begin() + begin, rows_.end());
    begin_.push_back(static_cast<int>(rows_.size()));
  }
}

void BlockConfinement::find_slots() {
  std::vector<int> at(p_.kept.size());
  std::vector<std::vector<std::pair<int, int>>> uses(p_.kept.size());  // of each kept node: (node, first slot)
  int count = 0;
  for (int j = 0; j + 1 < static_cast<int>(p_.begin.size()); ++j)
    for (int e = p_.begin[j]; e < p_.begin[j + 1]; ++e) {
      const auto from = near_.begin() + near_begin_[j], to = near_.begin() + near_begin_[j + 1];
      uses[p_.column[e]].emplace_back(j, count);
      count += static_cast<int>(to - std::lower_bound(from, to, p_.column[e]));
    }
  slots_.resize(static_cast<std::size_t>(count));
  for (int b = 0; b < static_cast<int>(uses.size()); ++b) {
    for (int k = begin_[b]; k < begin_[b + 1]; ++k) at[rows_[k]] = k;
    for (auto [j, slot] : uses[b])
      for (auto a = std::lower_bound(near_.begin() + near_begin_[j], near_.begin() + near_begin_[j + 1], b);
           a != near_.begin() + near_begin_[j + 1]; ++a)
        slots_[slot++] = at[*a];
  }
}

template <int Size>
void BlockConfinement::product(const NodeBlocks& blocks, const std::vector<double>& values,
                               std::vector<double>& out) const {
  out.assign(Size * rows_.size(), 0);
  std::vector<double> half;  // (P^T A) of one column, at its near kept nodes
  const unsigned short* place = place_.data();
  const int* slot = slots_.data();
  std::array<double, Size> transposed;
  for (int j = 0; j < blocks.num_nodes(); ++j) {
    const int begin = near_begin_[j], count = near_begin_[j + 1] - begin;
    half.assign(static_cast<std::size_t>(Size * count), 0);
    for (int k = blocks.first(j); k < blocks.last(j); ++k) {
      const int i = blocks.neighbour(k);
      const double* block = values.data() + static_cast<std::ptrdiff_t>(Size) * blocks.block(k);
      if (i < j) {
        transpose_blocks<Size>(block, transposed.data());
        block = transposed.data();
      }
      const int entries = p_.begin[i + 1] - p_.begin[i];
      const double* weight = p_.weight.data() + p_.begin[i];
      Size == 18 ? spread_18(block, weight, place, entries, half.data())
                 : spread_to<Size>(block, weight, place, entries, half.data());
      place += entries;
    }
    for (int e = p_.begin[j]; e < p_.begin[j + 1]; ++e) {
      const int* near = near_.data() + begin;
      const auto a = std::lower_bound(near, near + count, p_.column[e]) - near;
      Size == 18 ? add_18(half.data() + Size * a, p_.weight[e], slot, count - a, out.data())
                 : add_to<Size>(half.data() + Size * a, p_.weight[e], slot, count - a, out.data());
      slot += count - a;
    }
  }
}
template void BlockConfinement::product<9>(const NodeBlocks&, const std::vector<double>&, std::vector<double>&) const;
template void BlockConfinement::product<18>(const NodeBlocks&, const std::vector<double>&, std::vector<double>&) const;

}  // namespace kt
