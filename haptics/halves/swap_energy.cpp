#include "haptics/halves/swap_energy.hpp"

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace kt {

std::vector<double> stored_energy(const LocalModel& model, std::span<const VectorX> qs) {
  std::vector<double> out(qs.size(), std::numeric_limits<double>::quiet_NaN());
  if (model.dof() == 0) return out;
  const VectorX diagonal = model.stiffness.diagonal();
  if (!(diagonal.minCoeff() > 0)) return out;
  VectorX rest;
  if (model.stiffness.nonZeros() == model.dof()) {
    rest = model.f0.cwiseQuotient(diagonal);
  } else {
    const Eigen::LLT<MatrixX> llt{MatrixX(model.stiffness)};
    if (llt.info() != Eigen::Success) return out;
    rest = llt.solve(model.f0);
  }
  for (std::size_t i = 0; i < qs.size(); ++i) {
    if (qs[i].size() != rest.size()) continue;
    const VectorX away = qs[i] - rest;
    out[i] = 0.5 * away.dot(model.stiffness * away);
  }
  return out;
}

void SwapEnergy::add(const PreparedLocalModel& old) {
  const std::array<VectorX, 2> begin_and_end{old.adopted_q, old.state.q};
  const std::vector<double> energy = stored_energy(old.model, begin_and_end);
  const std::optional<double> before = std::exchange(left_, std::nullopt);
  if (!std::isfinite(energy[0] + energy[1])) return;
  left_ = energy[1];
  if (!before) return;
  const double given = energy[0] - *before;
  ++booked_.swaps;
  booked_.sum += given;
  if (std::abs(given) > std::abs(booked_.largest)) booked_.largest = given;
}

}  // namespace kt
