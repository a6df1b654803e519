#include "core/linear/step_solver.hpp"

namespace kt {

#define STEP_SOLVER(name, available, option, what) \
  std::unique_ptr<StepSolver> make_##name##_step_solver(StepSolverOptions options);
#include "core/linear/step_solvers.def"

std::vector<BackendInfo> step_solver_backends() {
  return {
#define STEP_SOLVER(name, available, option, what) {#name, what, available != 0, option},
#include "core/linear/step_solvers.def"
  };
}

std::unique_ptr<StepSolver> make_step_solver(const std::string& name, StepSolverOptions options) {
#define STEP_SOLVER(known, available, option, what) \
  if (name == #known) return make_##known##_step_solver(std::move(options));
#include "core/linear/step_solvers.def"
  require_backend("solver", name, step_solver_backends());
  return nullptr;
}

}  // namespace kt
