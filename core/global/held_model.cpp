#include "core/global/held_model.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <vector>

#include "core/body/node_weights.hpp"

namespace kt {
namespace {

Vec3 offset(const ContactHold& hold, const VectorX& x) { return hold.point - hold.moves.of(x); }

}  // namespace

HeldModel::HeldModel(const DeformableModel& model, std::span<const ContactHold> holds, double stiffness)
    : WrappingModel(model), holds_(holds), stiffness_(stiffness) {}

Mat3 HeldModel::spring(const ContactHold& hold) const {
  const Mat3 along_normal = hold.normal * hold.normal.transpose();
  if (hold.yields.isZero(0)) return stiffness_ * (hold.sticks ? Mat3(Mat3::Identity()) : along_normal);
  const Mat3 gives = hold.yields + Mat3(Mat3::Identity() / stiffness_);
  return hold.sticks ? Mat3(gives.inverse()) : Mat3(along_normal / hold.normal.dot(gives * hold.normal));
}

void HeldModel::force(const State& state, VectorX& out) const {
  model_.force(state, out);
  for (const ContactHold& hold : holds_) {
    hold.moves.add_to(out, spring(hold) * offset(hold, state.x));
  }
}

void HeldModel::added_stiffness(std::vector<Eigen::Triplet<double>>& out) const {
  for (const ContactHold& hold : holds_) {
    const Mat3 k = spring(hold);
    const NodeWeights& m = hold.moves;
    for (int a = 0; a < m.count; ++a)
      for (int b = 0; b < m.count; ++b)
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c)
            out.emplace_back(3 * m.node[a] + r, 3 * m.node[b] + c, -m.weight[a] * m.weight[b] * k(r, c));
  }
}

void HeldModel::update_tangent(const State& state, TangentKind kind, Tangent& out) const {
  model_.update_tangent(state, kind, out);
  std::vector<Eigen::Triplet<double>> springs;
  added_stiffness(springs);
  const auto is_known = [&](const Eigen::Triplet<double>& t) {
    const int* const begin = out.dfdx.innerIndexPtr() + out.dfdx.outerIndexPtr()[t.col()];
    const int* const end = out.dfdx.innerIndexPtr() + out.dfdx.outerIndexPtr()[t.col() + 1];
    return std::binary_search(begin, end, t.row());
  };
  if (std::ranges::all_of(springs, is_known)) {
    for (const auto& t : springs) out.dfdx.coeffRef(t.row(), t.col()) += t.value();
    return;
  }
  SparseMatrix added(out.dfdx.rows(), out.dfdx.cols());
  added.setFromTriplets(springs.begin(), springs.end());
  out.dfdx += added;
}

double HeldModel::push(const VectorX& x) const {
  double sum = 0;
  for (const ContactHold& hold : holds_) {
    const Vec3 apart = offset(hold, x);
    sum -= hold.yields.isZero(0) ? stiffness_ * hold.normal.dot(apart) : hold.normal.dot(spring(hold) * apart);
  }
  return sum;
}

}  // namespace kt
