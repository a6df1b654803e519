#include "haptics/tick/catch_up.hpp"

namespace kt {

CatchUp::CatchUp(std::span<const ToolShape> tools, double h, std::unique_ptr<ContactSolver> solver)
    : local_(tools, h, std::move(solver)) {}

void CatchUp::step(std::unique_ptr<PreparedLocalModel>& model, std::span<const ToolSweep> sweeps) noexcept {
  std::array<LocalFrame, kMaxTools> frames;
  local_.swap_model(model);
  local_.step_tools(sweeps, frames);
  local_.swap_model(model);
  for (std::size_t k = 0; k < sweeps.size(); ++k) {
    std::optional<Vec3>& force = model->replayed_force[k];
    force.reset();
    if (frames[k].mode != ContactMode::free) force = frames[k].force;
  }
}

}  // namespace kt
