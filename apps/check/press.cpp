// A sphere pressed in at places all over the surface: is the force finite, outward, and growing with the depth?
#include <cmath>

#include "apps/check/hand_paths.hpp"
#include "apps/check/mesh_work.hpp"
#include "apps/check/runs.hpp"
#include "core/error.hpp"

namespace kt {
namespace {

constexpr double kRest = 0.01;   // [s] at the end of each stop
constexpr double kRings = 0.05;  // of the largest force: less at a greater depth is not monotone
constexpr double kFalls = 0.3;   // more than a light body's ringing

/// Mean force along the normal when the body has come to rest, at each depth [N].
std::vector<double> force_over_depth(const SessionResult& run, const PressPath& path, const Vec3& normal) {
  std::vector<double> out;
  for (const double end : path.rests) {
    double sum = 0;
    int ticks = 0;
    for (const LocalFrame& f : run.frames)
      if (f.t > end - kRest && f.t <= end) {
        sum += f.force.dot(normal);
        ++ticks;
      }
    out.push_back(ticks > 0 ? sum / ticks : 0);
  }
  return out;
}

void judge_forces(const std::vector<double>& force, const std::string& name, const Vec3& where, StageResult& out) {
  const double largest = *std::ranges::max_element(force);
  if (!(force.back() > 0)) {
    out.lower(Verdict::fail, text(name, ": the force at full depth is ", force.back(), " N, not outward"), where);
    return;
  }
  for (std::size_t i = 1; i < force.size(); ++i)
    if (const double fall = force[i - 1] - force[i]; fall > kRings * largest) {
      out.lower(fall > kFalls * largest ? Verdict::fail : Verdict::degraded,
                text(name, ": deeper, but the force falls from ", force[i - 1], " to ", force[i], " N"), where);
      return;
    }
}

int free_between(const SessionResult& run, double from, double to) {
  return static_cast<int>(std::ranges::count_if(
      run.frames, [&](const LocalFrame& f) { return f.t > from && f.t <= to && f.mode == ContactMode::free; }));
}

/// A light body bounces off the tool that stops; by the second half of the hold it must lie against it, unless the
/// whole nonlinear body has swung away, too. Returns whether there is a force to be judged.
bool judge_hold(const CheckBody& body, const SessionResult& run, const PressPath& path, const std::string& name,
                const Vec3& where, const std::atomic<bool>* stop, RunExtremes& all, StageResult& out) {
  const double end = path.rests.back(), settled = 0.5 * (path.pressed + end);
  if (const int bounces = free_between(run, path.pressed, settled); bounces > 0)
    out.lower(Verdict::degraded, text(name, ": the body bounces off for ", bounces, " ticks where the tool stops"),
              where);
  const Loss loss = longest_loss(body, run, settled, end, stop);
  if (loss.ticks == 0) return true;
  all.lost += loss.ticks;
  const Verdict verdict = judge_loss(loss);
  out.lower(verdict, text(name, ": no contact while held, ", loss.told()), where);
  return verdict != Verdict::pass;
}

}  // namespace

void check_press(MeshWork& work, StageResult& out) {
  const auto thickest =
      static_cast<std::size_t>(std::ranges::max_element(work.spots, {}, &ContactSpot::thickness) - work.spots.begin());
  for (CheckBody& body : work.bodies) {
    RunExtremes all;
    double largest = 0, off = std::nan("");
    for (std::size_t i = 0; i < work.spots.size(); ++i) {
      const ContactSpot& spot = work.spots[i];
      const std::string name = text(body.model, ", place ", i + 1);
      const Vec3 where = work.in_file(spot.place);
      const PressPath path = press_path(spot);
      const SessionResult run = run_along(body, path.path, work.options.stop);
      judge_run(run, name, where, all, out);
      const auto force = force_over_depth(run, path, spot.normal);
      if (judge_hold(body, run, path, name, where, work.options.stop, all, out)) judge_forces(force, name, where, out);
      const double held = force.back();
      largest = std::max(largest, held);
      if (i != thickest) continue;
      const auto ticks = static_cast<std::size_t>(std::lround(path.rests[1] / run.frames.front().t));
      if (const auto truth = truth_of(body, run, ticks, work.options.stop))
        off = compare_forces(tick_forces(run.frames), *truth).force_error;
    }
    report_runs(all, body.model, out);
    out.figures[body.model]["largest_force"] = largest;
    out.figures[body.model]["force_error"] = std::isfinite(off) ? nlohmann::ordered_json(off) : nullptr;
  }
}

}  // namespace kt
