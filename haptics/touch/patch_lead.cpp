#include "haptics/touch/patch_lead.hpp"

#include <algorithm>

namespace kt {
namespace {

/// Both ends of every edge, once each way.
std::vector<std::array<int, 2>> edges_of(const Mesh& mesh) {
  std::vector<std::array<int, 2>> out;
  const auto add = [&](const auto& corners) {
    for (const int a : corners)
      for (const int b : corners)
        if (a != b) out.push_back({a, b});
  };
  for (const Tetrahedron& t : mesh.tetrahedra) add(t);
  if (mesh.tetrahedra.empty())
    for (const Triangle& t : mesh.triangles) add(t);
  std::ranges::sort(out);
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

}  // namespace

PatchLead::PatchLead(const Mesh& mesh, const std::vector<int>& held)
    : first_(static_cast<std::size_t>(mesh.num_nodes()) + 1, 0),
      is_held_(static_cast<std::size_t>(mesh.num_nodes()), 0) {
  for (const int i : held) is_held_[i] = 1;
  for (const auto& [a, b] : edges_of(mesh)) {
    ++first_[static_cast<std::size_t>(a) + 1];
    neighbour_.push_back(b);
  }
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
}

void PatchLead::fade(const VectorX& before, VectorX& x) const {
  const int n = static_cast<int>(is_held_.size());
  std::vector<int> row(static_cast<std::size_t>(n), -1), now, next;
  std::vector<Vec3> lead(static_cast<std::size_t>(n), Vec3::Zero());
  for (int i = 0; i < n; ++i) {
    lead[i] = node(x, i) - node(before, i);
    if (lead[i].squaredNorm() == 0) continue;
    row[i] = 0;
    now.push_back(i);
  }
  for (int k = 1; k < kRows && !now.empty(); ++k) {
    next.clear();
    for (const int i : now)
      for (int e = first_[i]; e < first_[i + 1]; ++e)
        if (const int j = neighbour_[e]; row[j] < 0 && !is_held_[j]) {
          row[j] = k;
          next.push_back(j);
        }
    for (const int j : next) {  // as the mean of its neighbours in the row before
      int count = 0;
      for (int e = first_[j]; e < first_[j + 1]; ++e)
        if (row[neighbour_[e]] == k - 1) {
          lead[j] += lead[neighbour_[e]];
          ++count;
        }
      lead[j] /= count;
      node(x, j) += (1 - static_cast<double>(k) / kRows) * lead[j];
    }
    now.swap(next);
  }
}

}  // namespace kt
