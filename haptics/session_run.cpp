#include "haptics/session_run.hpp"

#include <time.h>

#include <cmath>

#include "haptics/contact_check.hpp"

namespace kt {
namespace {

/// CPU time of this thread [us]: what the tick costs, whatever else runs on the machine.
double thread_time_us() noexcept {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

// Deeper than this counts as inside: far above the rounding of positions, far below what a hand or a picture shows.
constexpr double kInside = 1e-7;  // [m]

}  // namespace

bool catches_up(const Scene& scene) {
  return scene.local.catch_up && haptic_method_name(scene.local.method, scene.contact.law) == "multirate";
}

std::unique_ptr<ContactSolver> scene_solver(const Scene& scene, const SurfaceFriction& friction) {
  if (!catches_up(scene)) return {};
  return make_contact_solver(scene.contact.law, friction.everywhere, friction.of_triangle);
}

HapticLoop::HapticLoop(const Scene& scene, const ToolShape& tool, const SurfaceFriction& friction,
                       std::unique_ptr<HapticDevice> device, const SessionOptions& options)
    : options_(options),
      device_(std::move(device)),
      local_(make_scene_method(scene, tool, friction.of_triangle)),
      catch_up_(tool, 1 / scene.local.rate_hz, scene_solver(scene, friction)),
      turn_{scene.tool.turn, scene.tool.spin},
      limits_(device_->limits()),
      start_(device_->position(0)),
      position_(start_) {
  const auto ticks = static_cast<std::size_t>(std::llround(scene.duration * scene.local.rate_hz));
  frames_.resize(ticks);
  step_us_.resize(ticks);
  if (options.check_contacts) penetration_.resize(ticks);
}

LocalReport HapticLoop::tick() noexcept {
  const double t_end = (tick_ + 1) * local_->h();
  const Vec3 next = device_->position(t_end);
  const long long before = options_.count_allocations ? options_.count_allocations() : 0;
  const double start = thread_time_us();
  const ToolSweep sweep = turn_.sweep(position_, next, t_end - local_->h(), t_end);
  LocalFrame frame = local_->step(sweep);
  step_us_[tick_] = thread_time_us() - start;
  if (options_.count_allocations) allocations_ += options_.count_allocations() - before;

  bool limited = false;
  device_->write(safe_force(frame.force, limits_, limited), local_->h());
  limited_ += limited;
  position_ = next;
  frame.t = t_end;
  frames_[tick_] = frame;
  if (!penetration_.empty()) {
    const PreparedLocalModel& m = local_->model();
    VectorX x(3 * m.surface.facets.num_vertices());
    m.surface.follow(m.model.x0.head(m.patch_basis.rows()) + m.patch_basis * m.state.q, x);
    penetration_[tick_] = penetration_depth(m.surface.facets, x, local_->tool(), next, sweep.r_t1);
    missed_ += frame.mode == ContactMode::free && penetration_[tick_] > kInside;
  }

  LocalReport report;
  report.tick = tick_++;
  report.tool = next;
  for (const ContactSample& sample : local_->samples()) report.samples[report.count++] = sample;
  report.triangle = report.count == 0 ? -1 : frame.triangle;  // where the body is touched, whatever force is shown
  report.sliding = frame.mode == ContactMode::frictional_slide;
  report.left_patch = (frame.flags & kLeftPatch) != 0;
  return report;
}

bool HapticLoop::catch_up(std::unique_ptr<PreparedLocalModel>& model, int& at, int most) noexcept {
  for (int i = 0; i < most && at < tick_; ++i, ++at)
    catch_up_.step(model, turn_.sweep(at > 0 ? frames_[at - 1].tool : start_, frames_[at].tool, at * local_->h(),
                                      (at + 1) * local_->h()));
  model->caught_up = at == tick_;
  return model->caught_up;
}

std::unique_ptr<PreparedLocalModel> HapticLoop::adopt(std::unique_ptr<PreparedLocalModel> model) noexcept {
  last_dof_ = model->model.dof();
  last_vertices_ = model->model.patch.num_vertices();
  return local_->adopt(std::move(model));
}

Snapshot HapticLoop::snapshot(const VectorX& global_x) const {
  Snapshot out{tick_ * local_->h(), position_, global_x};
  const PreparedLocalModel& m = local_->model();
  const VectorX x = m.model.x0 + m.model.basis * m.state.q;
  for (int i = 0; i < static_cast<int>(m.model.recovered_node.size()); ++i)
    node(out.x, m.model.recovered_node[i]) = node(x, i);
  return out;
}

void HapticLoop::finish(SessionResult& out) {
  frames_.resize(tick_);
  step_us_.resize(tick_);
  if (!penetration_.empty()) penetration_.resize(tick_);
  StateHash hash;
  const double period_us = 1e6 * local_->h();
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    const LocalFrame& f = frames_[i];
    hash.add(f.tool);
    hash.add(f.force);
    hash.add(f.toi);
    hash.add(static_cast<int>(f.mode));
    hash.add(f.triangle);
    out.deadline_misses += step_us_[i] > period_us;
  }
  out.hash = hash.value();
  out.frames = std::move(frames_);
  out.step_us = std::move(step_us_);
  out.penetration = std::move(penetration_);
  out.limited_forces = limited_;
  out.missed_impacts = missed_;
  out.last_dof = last_dof_;
  out.last_patch_vertices = last_vertices_;
  if (options_.count_allocations) out.allocations = allocations_;
}

}  // namespace kt
