// By size. Conjugate gradients are the faster at any (docs/accuracy_and_speed.md); the factorization, which is exact
// and cannot fail to converge, serves where it takes less than 5 ms.
#include "core/step_solver.hpp"

namespace kt {

std::unique_ptr<StepSolver> make_automatic_step_solver(StepSolverOptions options) {
  constexpr Eigen::Index kFewNodes = 1000;
  const bool small = options.positions.size() < 3 * kFewNodes;
  return make_step_solver(small ? "direct" : "pcg", std::move(options));
}

}  // namespace kt
