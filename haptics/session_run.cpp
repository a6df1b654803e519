#include "haptics/session_run.hpp"

#include <time.h>

#include <algorithm>
#include <cmath>

namespace kt {
namespace {

/// CPU time of this thread [us]: what the tick costs, whatever else runs on the machine.
double thread_time_us() noexcept {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

constexpr std::size_t kRecorded = std::size_t{1} << 21;  // numbers: thousands of ticks of a usual local model

}  // namespace

double process_time_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

bool catches_up(const Scene& scene) {
  return scene.local.catch_up && haptic_method_name(scene.local.method, scene.contact.law) == "multirate";
}

std::unique_ptr<ContactSolver> scene_solver(const Scene& scene, const SurfaceFriction& friction) {
  if (!catches_up(scene)) return {};
  return make_contact_solver(scene.contact.law, friction.everywhere, friction.of_triangle);
}

HapticLoop::HapticLoop(const Scene& scene, std::span<const ToolShape> tools, const SurfaceFriction& friction,
                       std::vector<std::unique_ptr<HapticDevice>> devices, const SessionOptions& options,
                       const Surface& surface, bool check_later)
    : options_(options),
      local_(make_scene_method(scene, tools, friction.of_triangle)),
      catch_up_(tools, 1 / scene.local.rate_hz, scene_solver(scene, friction)) {
  const auto ticks = static_cast<std::size_t>(std::llround(scene.duration * scene.local.rate_hz));
  step_us_.resize(ticks);
  if (options.check_contacts) check_.emplace(surface, tools);
  if (options.check_contacts && check_later) record_ = std::make_unique<MotionRecord>(kRecorded);
  for (std::size_t k = 0; k < tools.size(); ++k) {
    Hand& hand = hands_.emplace_back();
    hand.device = std::move(devices[k]);
    hand.shape = tools[k];
    hand.turn = scene_turn(k == 0 ? scene.tool : *scene.second_tool);
    hand.limits = hand.device->limits();
    if (hand.limits.yields)
      hand.passivity.emplace(
          PassivityOptions{scene.local.passivity_damping, 1 / scene.local.rate_hz, hand.limits.delay});
    hand.start = hand.position = hand.device->position(0);
    hand.frames.resize(ticks);
    if (options.check_contacts) hand.penetration.resize(ticks);
  }
}

std::vector<Vec3> HapticLoop::tool_positions() const {
  std::vector<Vec3> out;
  for (const Hand& hand : hands_) out.push_back(hand.position);
  return out;
}

LocalReport HapticLoop::tick() noexcept {
  const double t_end = (tick_ + 1) * local_->h();
  const std::size_t count = hands_.size();
  std::array<ToolSweep, kMaxTools> sweeps;
  std::array<LocalFrame, kMaxTools> frames;
  for (std::size_t k = 0; k < count; ++k) sweeps[k].x_t1 = hands_[k].device->position(t_end);
  const long long before = options_.count_allocations ? options_.count_allocations() : 0;
  const double start = thread_time_us();
  for (std::size_t k = 0; k < count; ++k)
    sweeps[k] = hands_[k].turn.sweep(hands_[k].position, sweeps[k].x_t1, t_end - local_->h(), t_end);
  local_->step_tools(std::span(sweeps).first(count), std::span(frames).first(count));
  step_us_[tick_] = thread_time_us() - start;
  if (options_.count_allocations) allocations_ += options_.count_allocations() - before;

  LocalReport report;
  for (const ContactSample& sample : local_->samples()) report.samples[report.count++] = sample;
  for (std::size_t k = 0; k < count; ++k) {
    Hand& hand = hands_[k];
    LocalFrame& frame = frames[k];
    bool limited = false;
    if (hand.passivity) frame.force = hand.passivity->tick(sweeps[k].x_t1, frame.force);
    hand.device->write(safe_force(frame.force, hand.limits, limited), local_->h());
    hand.limited += limited;
    hand.position = sweeps[k].x_t1;
    frame.t = t_end;
    hand.frames[tick_] = frame;
    const bool touches = std::any_of(report.samples.begin(), report.samples.begin() + report.count,
                                     [&](const ContactSample& s) { return s.tool == static_cast<int>(k); });
    report.tools[k] = {hand.position, touches ? frame.triangle : -1,  // where it touches, whatever force is shown
                       frame.mode == ContactMode::frictional_slide};
    report.left_patch = report.left_patch || (frame.flags & kLeftPatch) != 0;
  }
  const PreparedLocalModel& m = local_->model();
  if (record_)
    hands_[0].lost.unchecked_ticks += !record_->push({tick_, m.model.frame}, m.state.q);
  else if (check_)
    look(tick_, m.state.q);
  report.tick = tick_++;
  return report;
}

/// As it was in a tick that is done.
ToolSweep HapticLoop::sweep_of(const Hand& hand, int tick) const {
  return hand.turn.sweep(tick > 0 ? hand.frames[tick - 1].tool : hand.start, hand.frames[tick].tool, tick * local_->h(),
                         (tick + 1) * local_->h());
}

/// Checks a tick that is done, with the model that was in use.
/// @param q  its coordinates at the end of it
void HapticLoop::look(int tick, const VectorX& q) {
  check_->place(q);
  for (std::size_t k = 0; k < hands_.size(); ++k) {
    Hand& hand = hands_[k];
    const ToolSweep sweep = sweep_of(hand, tick);
    const double depth = hand.penetration[tick] = check_->depth(static_cast<int>(k), sweep);
    const bool is_free = hand.frames[tick].mode == ContactMode::free;
    if (is_free && depth > BodyCheck::kInside) {
      ++hand.lost.free_ticks_inside;
    } else if (is_free ? check_->went_through(static_cast<int>(k), sweep)
                       : check_->leapt_into(static_cast<int>(k), sweep, depth)) {
      ++hand.lost.pass_throughs;
      if (hand.lost.went_through.size() < LostContact::kMostNamed)
        hand.lost.went_through.push_back({tick, (sweep.x_t1 - sweep.x_t0).norm()});
    }
  }
}

bool HapticLoop::look_at_past(const PreparedLocalModel& model, int most) {
  for (int i = 0; i < most; ++i) {
    MotionRecord::Tick tick;
    if (!record_ || !record_->front(tick, past_q_) || tick.frame != model.model.frame) return false;
    if (past_frame_ != tick.frame) check_->take(model);
    past_frame_ = tick.frame;
    look(tick.tick, past_q_);
    record_->pop();
  }
  return true;
}

bool HapticLoop::catch_up(std::unique_ptr<PreparedLocalModel>& model, int& at, int most) noexcept {
  std::array<ToolSweep, kMaxTools> sweeps;
  for (int i = 0; i < most && at < tick_; ++i, ++at) {
    for (std::size_t k = 0; k < hands_.size(); ++k) {
      const Hand& hand = hands_[k];
      sweeps[k] = hand.turn.sweep(at > 0 ? hand.frames[at - 1].tool : hand.start, hand.frames[at].tool,
                                  at * local_->h(), (at + 1) * local_->h());
    }
    catch_up_.step(model, std::span(sweeps).first(hands_.size()));
  }
  model->caught_up = at == tick_;
  return model->caught_up;
}

std::unique_ptr<PreparedLocalModel> HapticLoop::adopt(std::unique_ptr<PreparedLocalModel> model) noexcept {
  last_dof_ = model->model.dof();
  last_vertices_ = model->model.patch.num_vertices();
  auto before = local_->adopt(std::move(model));
  if (check_ && !record_) check_->take(local_->model());
  return before;
}

Snapshot HapticLoop::snapshot(const VectorX& global_x) const {
  Snapshot out{tick_ * local_->h(), hands_[0].position, global_x};
  if (hands_.size() > 1) out.second_tool = hands_[1].position;
  const PreparedLocalModel& m = local_->model();
  const VectorX x = m.model.x0 + m.model.basis * m.state.q;
  for (int i = 0; i < static_cast<int>(m.model.recovered_node.size()); ++i)
    node(out.x, m.model.recovered_node[i]) = node(x, i);
  return out;
}

std::optional<PassivityRun> HapticLoop::Hand::energy() const {
  if (!passivity) return {};
  return PassivityRun{passivity->least(), passivity->most(), passivity->most_debt(), passivity->given_by_hold(),
                      passivity->damped_ticks()};
}

void HapticLoop::finish(SessionResult& out) {
  step_us_.resize(tick_);
  StateHash hash;
  for (Hand& hand : hands_) {
    hand.frames.resize(tick_);
    if (!hand.penetration.empty()) hand.penetration.resize(tick_);
    for (const LocalFrame& f : hand.frames) {
      hash.add(f.tool);
      hash.add(f.force);
      hash.add(f.toi);
      hash.add(static_cast<int>(f.mode));
      hash.add(f.triangle);
    }
  }
  out.hash = hash.value();
  const double period_us = 1e6 * local_->h();
  out.deadline_misses = static_cast<int>(std::ranges::count_if(step_us_, [&](double us) { return us > period_us; }));
  out.step_us = std::move(step_us_);
  Hand& first = hands_[0];
  out.start = first.start;
  out.frames = std::move(first.frames);
  out.penetration = std::move(first.penetration);
  out.limited_forces = first.limited;
  out.missed_impacts = first.lost.free_ticks_inside + first.lost.pass_throughs;
  out.lost = std::move(first.lost);
  out.passivity = first.energy();
  if (out.second_tool) {
    Hand& second = hands_[1];
    *out.second_tool = {second.start,
                        std::move(second.frames),
                        std::move(second.penetration),
                        second.limited,
                        second.lost.free_ticks_inside + second.lost.pass_throughs,
                        second.lost,
                        out.second_tool->max_speed,
                        second.energy()};
  }
  out.last_dof = last_dof_;
  out.last_patch_vertices = last_vertices_;
  if (options_.count_allocations) out.allocations = allocations_;
}

}  // namespace kt
