#include "haptics/tick/local_simulation.hpp"

#include <algorithm>
#include <utility>

#include "haptics/tick/coulomb_tick.hpp"
#include "haptics/tick/model_change.hpp"
#include "haptics/tick/paper_tick.hpp"
#include "haptics/tick/tick_stages.hpp"

namespace kt {
namespace {

void begin_tick(TickState& tick, std::span<const ToolSweep> sweeps, std::span<LocalFrame> frames) noexcept {
  tick.num_samples = 0;
  tick.residual = 0;
  tick.work = ContactWork(tick.most_work);
  tick.t += tick.h;
  for (int k = 0; k < tick.num_tools(); ++k) {
    frames[k] = {};
    frames[k].t = tick.t;
    frames[k].pose = {sweeps[k].x_t1, sweeps[k].r_t1};
    frames[k].model_frame = tick.model->model.frame;
    tick.tools[k].whole.move(sweeps[k]);
  }
}

/// Back to the linearization pose, the last state known to be good, where a number is not finite.
void keep_finite(TickState& tick, std::span<LocalFrame> frames) noexcept {
  LocalState& s = tick.model->state;
  const auto used = frames.first(tick.tools.size());
  const auto is_finite = [](const LocalFrame& frame) { return frame.force.allFinite(); };
  if (s.q.allFinite() && s.q_rate.allFinite() && s.yielded.allFinite() && std::ranges::all_of(used, is_finite)) return;
  s.q.setZero();
  s.q_rate.setZero();
  s.yielded.setZero();
  s.anchors.count = 0;
  tick.num_samples = 0;
  for (LocalFrame& frame : used) {
    frame.force.setZero();
    frame.mode = ContactMode::free;
  }
  tick.add_flag(kNotFinite);
}

void end_tick(TickState& tick, std::span<LocalFrame> frames) noexcept {
  for (int k = 0; k < tick.num_tools(); ++k) {
    shape_force(tick, k, frames[k]);
    tick.model->state.sliding[k] = frames[k].mode == ContactMode::frictional_slide;
    frames[k].flags = std::exchange(tick.tools[k].flags, 0u);
    frames[k].residual = tick.residual;
  }
}

}  // namespace

void step_tick(TickState& tick, std::span<const ToolSweep> sweeps, std::span<LocalFrame> frames) noexcept {
  begin_tick(tick, sweeps, frames);
  find_free_motion(tick);
  if (tick.solver->deformation() == Deformation::none)
    step_coulomb(tick, frames);
  else
    step_paper(tick, frames[0]);
  keep_finite(tick, frames);
  end_tick(tick, frames);
}

std::unique_ptr<PreparedLocalModel> LocalSimulation::adopt(std::unique_ptr<PreparedLocalModel> next) noexcept {
  model_.swap(next);
  change_model(tick_, *model_, next.get());
  return next;
}

void LocalSimulation::set_force(const VectorX& force) noexcept {
  LocalModel& m = model_->model;
  const LocalState& s = model_->state;
  m.f0 = force;
  m.f0.noalias() += m.stiffness * s.q;
  m.f0.noalias() += m.damping * s.q_rate;
}

LocalFrame LocalSimulation::step(const ToolSweep& sweep) noexcept {
  LocalFrame frame;
  step_tools({&sweep, 1}, {&frame, 1});
  return frame;
}

}  // namespace kt
