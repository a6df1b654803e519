#pragma once
// Bringing a new local model to the present: it is linearized at an earlier tick, and the tool has moved since.
// Replaying the tool's path through it gives the state that it would have had; starting it from the tool's pose at
// arrival leaves out what the body did meanwhile.
#include "haptics/tick/tick_state.hpp"

namespace kt {

/// [s] that a new local model is stepped beside the old one before it takes over: the parts of the body that it follows
/// and the old one did not start from rest. Without them its first forces can be a quarter off.
constexpr double kRunIn = 0.004;

/// Steps local models apart from the running one. One thread at a time.
class CatchUp {
 public:
  CatchUp(std::span<const ToolShape> tools, double h, std::unique_ptr<ContactSolver> solver);
  /// One tick of `model` with each tool moving along its sweep. No allocation.
  void step(PreparedLocalModel& model, std::span<const ToolSweep> sweeps) noexcept;

 private:
  TickState tick_;
};

}  // namespace kt
