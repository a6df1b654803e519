#pragma once
// The 1 kHz side: free motion, first time of impact, rollback, stick or slip, force.          Paper section IV, fig. 2.
#include <limits>
#include <memory>
#include <span>

#include "haptics/tick/haptic_method.hpp"
#include "haptics/tick/tick_state.hpp"

namespace kt {

/// One haptic tick of the model in use, by the tick of the solver's law: Coulomb's or the paper's. A frame for each
/// tool. No allocation, lock or clock.
void step_tick(TickState& tick, std::span<const ToolSweep> sweeps, std::span<LocalFrame> frames) noexcept;

/// One tool, or two that touch the same body at the same time: one local model, one W over all contacts, so that each
/// hand feels what the other does in the same tick.
class LocalSimulation final : public HapticMethod {
 public:
  /// @param blend  over which the difference between two local models fades from the force [s]; 0: not at all
  LocalSimulation(const ToolShape& tool, double h, std::unique_ptr<ContactSolver> solver, double blend = 0)
      : LocalSimulation(std::span<const ToolShape>(&tool, 1), h, std::move(solver), blend) {}
  /// @param tools  1 to kMaxTools; the paper's laws know one
  LocalSimulation(std::span<const ToolShape> tools, double h, std::unique_ptr<ContactSolver> solver, double blend = 0)
      : tick_(tools, h, std::move(solver), blend) {}

  /// Goes over to a new local model: patch motion and contacts are carried over by node and triangle, unless the new
  /// model is caught up already. No allocation; gives the old model back, to be freed elsewhere.
  std::unique_ptr<PreparedLocalModel> adopt(std::unique_ptr<PreparedLocalModel> next) noexcept override;

  void go_on_from(std::span<const std::optional<Vec3>> forces) noexcept override {
    for (std::size_t k = 0; k < tick_.tools.size(); ++k)
      tick_.tools[k].blend.go_on_from(k < forces.size() ? forces[k] : std::nullopt);
  }

  /// The body's force at the present state is `force` [N], (r), whatever the linear model has for it: the model's
  /// constant part follows. For bodies whose nonlinear force is at hand at every tick.
  void set_force(const VectorX& force) noexcept;

  /// Each tick ends when its contacts are solved, however long that takes: a reference has no clock.
  void take_all_work() noexcept { tick_.most_work = std::numeric_limits<long>::max(); }

  /// One haptic tick with the tool moving along `sweep`. Needs an adopted model. No allocation, lock or clock.
  LocalFrame step(const ToolSweep& sweep) noexcept override;

  /// The same with each tool moving along its own sweep; a frame for each.
  void step_tools(std::span<const ToolSweep> sweeps, std::span<LocalFrame> frames) noexcept override {
    step_tick(tick_, sweeps, frames);
  }

  /// What the last tick did to the body, for the global side.
  std::span<const TickContact> samples() const noexcept override {
    return {tick_.samples.data(), static_cast<std::size_t>(tick_.num_samples)};
  }

  const PreparedLocalModel& model() const noexcept override { return *model_; }
  double h() const noexcept override { return tick_.h; }
  const ToolShape& tool() const noexcept override { return tick_.tools[0].shape(); }

 private:
  std::unique_ptr<PreparedLocalModel> model_;
  TickState tick_;
};

}  // namespace kt
