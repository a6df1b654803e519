#include "haptics/cost/refined_share.hpp"

#include <Eigen/SparseCholesky>
#include <limits>
#include <unordered_map>

#include "core/local/fine_patch.hpp"

namespace kt {
namespace {

/// f S f of forces on the recovered nodes, (3 recovered).
double work_on_body(const LocalModel& model, const VectorX& force) {
  constexpr double kTime = 0.1;  // [s]
  const VectorX reduced = model.basis.transpose() * force;
  const Eigen::SimplicialLDLT<SparseMatrix> stiffness(model.stiffness + model.mass / (kTime * kTime));
  if (stiffness.info() != Eigen::Success) return std::numeric_limits<double>::quiet_NaN();
  return reduced.dot(VectorX(stiffness.solve(reduced)));
}

}  // namespace

double refined_share(const LocalModel& model, std::span<const TickContact> contacts) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  if (!model.fine || contacts.empty()) return kUnknown;
  const FinePatch& fine = *model.fine;
  std::unordered_map<int, int> row;
  for (std::size_t i = 0; i < model.recovered_node.size(); ++i)
    row.emplace(model.recovered_node[i], static_cast<int>(i));
  VectorX on_body = VectorX::Zero(3 * static_cast<Eigen::Index>(row.size())), on_cells = VectorX::Zero(fine.R.rows());
  for (const TickContact& contact : contacts) {
    const auto [facet, bary] = fine.find({contact.triangle, contact.bary});
    if (facet < 0) continue;
    const NodeWeights moves = fine.moved_by(facet, bary);
    for (int k = 0; k < moves.count; ++k)
      if (const auto at = row.find(moves.node[k]); at != row.end())
        node(on_body, at->second) += moves.weight[k] * contact.impulse;
    fine.yields_with(facet, bary).add_to(on_cells, contact.impulse);
  }
  const double cells = on_cells.dot(fine.R * on_cells);
  return cells > 0 ? cells / (cells + work_on_body(model, on_body)) : kUnknown;
}

}  // namespace kt
