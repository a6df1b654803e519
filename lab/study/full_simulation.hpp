#pragma once
// The whole nonlinear body under the engine's own contact tick, at one fine rate and without a slow side: the truth
// that multi-rate methods are measured against; docs/method.md#8-what-is-measured.
//
// Each step is one of linearly implicit Euler: with the exact force f(x, v), and a matrix A = M + h D + h^2 K that may
// be some steps old (a W-method: its order, one, does not depend on the matrix; Steihaug and Wolfbrandt 1979),
//   A (v+ - v) = h f(x, v) - h^2 K v + J^T p,   x+ = x + h v+.
// The local model at hand is linear, A v+ = h (f0 - K q) + M q', so it takes that step when f0 = f(x, v) + K q + D q'.
#include "core/linear/free_dofs.hpp"
#include "haptics/tick/local_simulation.hpp"
#include "haptics/tick/way_out.hpp"

namespace kt {

struct FullOptions {
  double h = 1e-4;                           ///< step [s]
  double matrix_time = 0.02;                 ///< time that one matrix A serves [s]
  TangentKind tangent = TangentKind::exact;  ///< of the matrix; definite where the exact one cannot be solved with
  bool exact_force = true;                   ///< false: linear while the matrix serves, to see what that alone does
  double max_speed = 0;                      ///< bound of the tools' speed [m/s]: how far they get in that time
  Metric metric = Metric::implicit;          ///< in which contact constraints act
  Smoothing smoothing{};                     ///< of the surface that the tool touches
  std::string collision_backend = "auto";    ///< name in collision/broad/triangle_index.def
};

class FullSimulation {
 public:
  /// @param tools  1 to kMaxTools
  FullSimulation(const DeformableModel& model, const Surface& surface, std::span<const ToolShape> tools,
                 std::unique_ptr<ContactSolver> solver, const FullOptions& options, const State& start);

  /// One step with the tool moving along `sweep`. Throws RunError when the step's matrix is not positive definite or
  /// the state leaves the finite numbers.
  LocalFrame step(const ToolSweep& sweep);
  /// The same with each tool moving along its own sweep; a frame for each.
  void step_tools(std::span<const ToolSweep> sweeps, std::span<LocalFrame> frames);

  const State& state() const { return state_; }
  int num_matrices() const { return num_matrices_; }

 private:
  void renew_matrix(std::span<const ToolSweep> sweeps);
  void read_state();
  const DeformableModel& model_;
  const Surface& surface_;
  WayOutSearch way_out_;
  FullOptions options_;
  FreeDofs dofs_;
  LocalSimulation local_;
  State state_;
  VectorX force_;         // (3n)
  VectorX x_linearized_;  // of the matrix, (3n)
  int steps_left_ = 0, num_matrices_ = 0;
  std::vector<ToolShape> tools_;
  std::vector<int> triangle_;  // that each tool touches, -1
};

}  // namespace kt
