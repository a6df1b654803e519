#include "haptics/catch_up.hpp"

namespace kt {

CatchUp::CatchUp(const ToolShape& tool, double h, std::unique_ptr<ContactSolver> solver)
    : local_(tool, h, std::move(solver)) {}

void CatchUp::step(std::unique_ptr<PreparedLocalModel>& model, const ToolSweep& sweep) noexcept {
  local_.swap_model(model);
  local_.step(sweep);
  local_.swap_model(model);
}

}  // namespace kt
