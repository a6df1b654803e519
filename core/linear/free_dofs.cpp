#include "core/linear/free_dofs.hpp"

namespace kt {

FreeDofs make_free_dofs(int num_nodes, const std::vector<int>& fixed_nodes) {
  std::vector<char> fixed(num_nodes, 0);
  for (int i : fixed_nodes) fixed[i] = 1;
  FreeDofs out;
  out.to_free.assign(3 * num_nodes, -1);
  for (int i = 0; i < num_nodes; ++i)
    for (int c = 0; c < 3 && !fixed[i]; ++c) {
      out.to_free[3 * i + c] = out.size();
      out.to_all.push_back(3 * i + c);
    }
  return out;
}

VectorX gather(const FreeDofs& dofs, const VectorX& all) {
  VectorX out(dofs.size());
  for (int i = 0; i < dofs.size(); ++i) out[i] = all[dofs.to_all[i]];
  return out;
}

SparseMatrix gather(const FreeDofs& dofs, const SparseMatrix& all) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(all.nonZeros());
  for (int c = 0; c < all.outerSize(); ++c) {
    if (dofs.to_free[c] < 0) continue;
    for (SparseMatrix::InnerIterator it(all, c); it; ++it)
      if (const int row = dofs.to_free[it.row()]; row >= 0) entries.emplace_back(row, dofs.to_free[c], it.value());
  }
  SparseMatrix out(dofs.size(), dofs.size());
  out.setFromTriplets(entries.begin(), entries.end());
  return out;
}

void scatter(const FreeDofs& dofs, const VectorX& free, VectorX& out) {
  for (int i = 0; i < dofs.size(); ++i) out[dofs.to_all[i]] = free[i];
}

}  // namespace kt
