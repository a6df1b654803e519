#include "lab/study/full_simulation.hpp"

#include <cmath>

#include "core/body/embedded_surface.hpp"
#include "haptics/refresh/refresher.hpp"

namespace kt {

FullSimulation::FullSimulation(const DeformableModel& model, const Surface& surface, std::span<const ToolShape> tools,
                               std::unique_ptr<ContactSolver> solver, const FullOptions& options, const State& start)
    : model_(model),
      surface_(surface),
      way_out_(surface, model.mesh().num_nodes(), still_nodes(model)),
      options_(options),
      dofs_(make_free_dofs(model.mesh().num_nodes(), model.fixed_nodes())),
      local_(tools, options.h, std::move(solver)),
      state_(start),
      tools_(tools.begin(), tools.end()),
      triangle_(tools.size(), -1) {
  local_.take_all_work();
  for (int i : model.fixed_nodes()) node(state_.v, i).setZero();
}

LocalFrame FullSimulation::step(const ToolSweep& sweep) {
  LocalFrame frame;
  step_tools({&sweep, 1}, {&frame, 1});
  return frame;
}

void FullSimulation::step_tools(std::span<const ToolSweep> sweeps, std::span<LocalFrame> frames) {
  if (steps_left_ == 0) renew_matrix(sweeps);
  --steps_left_;
  if (options_.exact_force) {
    model_.force(state_, force_);
    local_.set_force(gather(dofs_, force_));
  }
  local_.step_tools(sweeps, frames);
  read_state();
  state_.t += options_.h;
  for (std::size_t k = 0; k < tools_.size(); ++k) {
    LocalFrame& frame = frames[k];
    frame.t = state_.t;
    triangle_[k] = frame.mode == ContactMode::free ? -1 : frame.triangle;
    if (frame.flags & kLeftPatch) steps_left_ = 0;  // a patch around the present place
    if (frame.flags & kNotFinite)
      throw RunError(text("full model: the state left the finite numbers at t = ", state_.t, " s; raise the rate"));
  }
}

/// Linearizes where the body is now: the coordinates start again from zero, contacts go on.
void FullSimulation::renew_matrix(std::span<const ToolSweep> sweeps) {
  steps_left_ = std::max(1, static_cast<int>(std::lround(options_.matrix_time / options_.h)));
  constexpr double kRounding = 1e-7;  // [m]
  std::vector<ToolPlace> places;
  std::array<int, kMaxTools> way_out{kNotLooked, kNotLooked};
  for (std::size_t k = 0; k < tools_.size(); ++k) {
    const double reach = 1.5 * tool_reach(tools_[k]) + options_.max_speed * steps_left_ * options_.h;
    places.push_back({sweeps[k].x_t0, triangle_[k], reach});
    if (num_matrices_ > 0) continue;  // later, a tool that had no contact was outside
    const auto way = way_out_.find(state_.x, tools_[k], sweeps[k].x_t0, sweeps[k].r_t0, kRounding,
                                   static_cast<int>(tools_[k].corners.size()));
    way_out[k] = way ? way->triangle : kOutside;
    if (!way) continue;
    places.back().triangle = way->triangle;
    places.back().reach += way->depth;
  }
  const ContactSite site = find_contact_sites(surface_, state_.x, places);
  const SurfacePatch patch = make_patch(surface_, state_.x, site, options_.smoothing.levels > 0);
  const auto prepare_with = [&](TangentKind kind) {
    LocalModel model = find_reducer("full")(linearize(model_, state_, kind), patch, site, {});
    model.frame = num_matrices_;
    return prepare(std::move(model), LocalScheme::implicit_euler, options_.metric, options_.h,
                   options_.collision_backend, model_.mesh().num_own_nodes(),
                   static_cast<int>(surface_.triangles.size()), options_.smoothing);
  };
  std::unique_ptr<PreparedLocalModel> next;
  try {
    next = prepare_with(options_.tangent);
  } catch (const RunError&) {
    if (options_.tangent == TangentKind::definite) throw;
    // A is indefinite: any other matrix does, the force is exact anyway
    next = prepare_with(TangentKind::definite);
  }
  next->way_out = way_out;
  local_.adopt(std::move(next));
  x_linearized_ = state_.x;
  ++num_matrices_;
}

void FullSimulation::read_state() {
  const LocalState& local = local_.model().state;
  for (int i = 0; i < dofs_.size(); ++i) {
    const int k = dofs_.to_all[i];
    state_.x[k] = x_linearized_[k] + local.q[i];
    state_.v[k] = local.q_rate[i];
  }
  if (const auto& embedded = model_.mesh().embedded) {
    embedded->follow(state_.x);
    embedded->follow(state_.v);
  }
}

}  // namespace kt
