#include "haptics/tick/catch_up.hpp"

#include "haptics/tick/local_simulation.hpp"

namespace kt {

CatchUp::CatchUp(std::span<const ToolShape> tools, double h, std::unique_ptr<ContactSolver> solver)
    : tick_(tools, h, std::move(solver), 0) {}

void CatchUp::step(PreparedLocalModel& model, std::span<const ToolSweep> sweeps) noexcept {
  std::array<LocalFrame, kMaxTools> frames;
  use_model(tick_, model);
  step_tick(tick_, sweeps, frames);
  for (std::size_t k = 0; k < sweeps.size(); ++k) {
    std::optional<Vec3>& force = model.replayed_force[k];
    force.reset();
    if (frames[k].mode != ContactMode::free) force = frames[k].force;
  }
}

}  // namespace kt
