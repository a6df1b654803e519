#include "core/global/global_simulation.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/body/embedded_surface.hpp"

namespace kt {
namespace {

constexpr double kHoldStiffness = 1e5;  // [N/m] at least: a hundred times any tissue under a tool
constexpr double kHarder = 500;  // than a node of the body is held by its neighbours: some thousandths of an error

/// Of springs that hold touched points where the tool left them [N/m]. Of a stiff body they are stiffer, too: they
/// would give way in its place.
double hold_stiffness(const DeformableModel& model, const State& state) {
  const VectorX diagonal = -model.tangent(state, TangentKind::definite).dfdx.diagonal();
  std::vector<double> springs;
  for (double k : diagonal)
    if (k > 0) springs.push_back(k);
  if (springs.empty()) return kHoldStiffness;
  const auto middle = springs.begin() + static_cast<std::ptrdiff_t>(springs.size() / 2);
  std::ranges::nth_element(springs, middle);
  return std::max(kHoldStiffness, kHarder * *middle);
}

/// The model with its touched points on their way: where the body has them at the start of a step, and where the tool
/// left them at its end. A stage in between that had them at the end already would be a blow to the body. Integrators
/// whose states stay at the time of the start ask for forces at the end only.
class MovingHolds final : public WrappingModel {
 public:
  MovingHolds(const DeformableModel& model, std::span<const ContactHold> holds, double stiffness, const State& start,
              double dt)
      : WrappingModel(model), holds_(holds), stiffness_(stiffness), t_(start.t), dt_(dt) {
    for (const ContactHold& hold : holds)  // with the force that it had, what gives way is that far away
      from_.push_back(hold.moves.of(start.x) + hold.yields * (hold.friction - hold.force * hold.normal));
  }
  void force(const State& state, VectorX& out) const override {
    const double share = (state.t - t_) / dt_;
    if (!(share > 0 && share < 1)) return at_end().force(state, out);
    std::vector<ContactHold> now(holds_.begin(), holds_.end());
    for (std::size_t i = 0; i < now.size(); ++i) now[i].point = from_[i] + share * (now[i].point - from_[i]);
    HeldModel(model_, now, stiffness_).force(state, out);
  }
  void update_tangent(const State& state, TangentKind kind, Tangent& out) const override {
    at_end().update_tangent(state, kind, out);  // the same all the way
  }
  const DeformableModel& base() const override { return model_; }
  void added_stiffness(std::vector<Eigen::Triplet<double>>& out) const override { at_end().added_stiffness(out); }
  double push(const VectorX& x) const { return at_end().push(x); }

 private:
  HeldModel at_end() const { return {model_, holds_, stiffness_}; }
  std::span<const ContactHold> holds_;
  double stiffness_, t_, dt_;
  std::vector<Vec3> from_;
};

}  // namespace

GlobalSimulation::GlobalSimulation(const DeformableModel& model, std::unique_ptr<Integrator> integrator,
                                   double max_step, std::optional<State> start)
    : all_(model),
      model_(model.own()),
      integrator_(std::move(integrator)),
      max_step_(max_step),
      state_(start ? own_part(model, *start) : rest_state(model_)) {
  show(state_, shown_);
  unconditional_ = !std::isfinite(integrator_->stable_step({.omega = 1, .zeta = 0}));
  if (unconditional_) {
    hold_stiffness_ = hold_stiffness(model, state_);
    return;
  }
  // 80 %: the mode is estimated from below, and contact and stretching stiffen the body a little.
  max_step_ = std::min(max_step_, 0.8 * integrator_->stable_step(fastest_mode(model, state_)));
}

std::optional<State> GlobalSimulation::foresee(double dt, std::span<const std::vector<ContactHold>> stops) {
  if (!unconditional_ || stops.empty() || dt <= 0) return {};
  const double step = dt / static_cast<double>(stops.size());
  State ahead = state_;
  for (const std::vector<ContactHold>& holds : stops) {
    if (holds.empty()) return {};
    VectorX friction = VectorX::Zero(ahead.x.size());
    for (const ContactHold& hold : holds) hold.moves.add_to(friction, friction_scale_ * hold.friction);
    const MovingHolds held(model_, holds, hold_stiffness_, ahead, step);
    integrator_->look_ahead(held, friction, step, ahead);
    if (held.push(ahead.x) < 0) return {};
  }
  ahead.t = state_.t + dt;
  if (!ahead.x.allFinite() || !ahead.v.allFinite()) return {};
  if (&all_ == &model_) return ahead;
  State shown;
  show(ahead, shown);
  return shown;
}

void GlobalSimulation::warm_up(double dt) {
  if (!unconditional_) return;
  State ahead = state_;
  try {
    integrator_->look_ahead(model_, VectorX::Zero(ahead.x.size()), dt, ahead);
  } catch (const RunError&) {  // the first step will tell, if it fails as well
  }
}

/// With the vertices of an embedded surface, which go with their cells.
void GlobalSimulation::show(const State& own, State& out) const {
  if (&all_ == &model_) return;
  out.t = own.t;
  for (const auto& [from, to] : {std::pair(&own.x, &out.x), std::pair(&own.v, &out.v)}) {
    to->resize(all_.mesh().x.size());
    to->head(from->size()) = *from;
    all_.mesh().embedded->follow(*to);
  }
}

/// False, and nothing has changed, when the holds would have to pull.
bool GlobalSimulation::advance_held(double t_end, std::span<const ContactSample> history,
                                    std::span<const ContactHold> holds) {
  const double dt = t_end - state_.t;
  const bool all_stick = std::all_of(holds.begin(), holds.end(), [](const ContactHold& h) { return h.sticks; });
  VectorX friction = VectorX::Zero(state_.x.size());
  double normal_impulse = 0;
  for (const ContactSample& s : history) {
    const double along = s.normal.dot(s.impulse);
    normal_impulse -= along;
    if (all_stick || s.sticks) continue;  // what sticks is held in all directions
    s.moves.add_to(friction, friction_scale_ / dt * (s.impulse - along * s.normal));
  }
  const MovingHolds held(model_, holds, hold_stiffness_, state_, dt);
  const State before = state_;
  integrator_->step(held, friction, dt, state_);
  state_.t = t_end;
  const double push = held.push(state_.x);
  double local_force = 0;
  for (const ContactHold& hold : holds) local_force += hold.force;
  if (push < 0) {
    state_ = before;
    if (local_force > 0) contact_error_ = -1;
    return false;
  }
  if (local_force > 0) contact_error_ = push / local_force - 1;
  if (normal_impulse > 0) friction_scale_ = std::clamp(push * dt / normal_impulse, 0.0, 1.0);
  return true;
}

void GlobalSimulation::advance(double t_end, std::span<const ContactSample> history,
                               std::span<const ContactHold> holds) {
  contact_error_ = 0;
  if (unconditional_ && !holds.empty() && t_end > state_.t && advance_held(t_end, history, holds))
    return show(state_, shown_);
  if (t_end <= state_.t) return;
  const int steps =
      unconditional_ ? 1 : std::max(1, static_cast<int>(std::ceil((t_end - state_.t) / max_step_ - 1e-9)));
  const double t_begin = state_.t, dt = (t_end - t_begin) / steps;
  VectorX external(state_.x.size());
  std::size_t next = 0;
  for (int i = 0; i < steps; ++i) {
    const double t_next = i + 1 == steps ? t_end : t_begin + (i + 1) * dt;
    external.setZero();
    for (; next < history.size() && (i + 1 == steps || history[next].t < t_next - 1e-9 * dt); ++next)
      history[next].moves.add_to(external, history[next].impulse / dt);
    integrator_->step(model_, external, dt, state_);
    state_.t = t_next;
  }
  show(state_, shown_);
  if (!state_.x.allFinite() || !state_.v.allFinite())
    throw RunError(text("the global model left the finite numbers before t = ", t_end,
                        " s: soften the model, raise global.rate_hz or use global.integrator implicit_euler"));
}

}  // namespace kt
