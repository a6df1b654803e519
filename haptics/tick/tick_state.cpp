#include "haptics/tick/tick_state.hpp"

namespace kt {

TickState::TickState(std::span<const ToolShape> shapes, double step, std::unique_ptr<ContactSolver> law, double blend)
    : h(step), solver(std::move(law)) {
  KT_ASSERT(!shapes.empty() && shapes.size() <= static_cast<std::size_t>(kMaxTools));
  for (const ToolShape& shape : shapes) tools.emplace_back(shape, h, blend);
  problem.velocity.setZero(3 * kMaxContacts);
  problem.W.setZero(3 * kMaxContacts, 3 * kMaxContacts);
  solution.impulse.setZero(0);
}

void use_model(TickState& tick, PreparedLocalModel& model) noexcept {
  if (tick.model != &model) tick.coupled_in = -1;
  tick.model = &model;
  tick.solver->use(model.friction.get());
  for (int k = 0; k < tick.num_tools(); ++k) {
    TouchingTool& tool = tick.tools[k];
    const double radius = model.tool_radius[k];
    if (radius < 0 || radius == tool.shape().radius) continue;
    tool.whole.set_radius(radius);
    tool.rest.set_radius(radius);
    tool.reach = tool_reach(tool.shape());
  }
}

}  // namespace kt
