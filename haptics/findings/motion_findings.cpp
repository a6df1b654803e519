// A tool that is faster than local models are made for, and a hand that is given energy.
#include "core/base/error.hpp"
#include "haptics/findings/kinds.hpp"
#include "haptics/refresh/refresher.hpp"

namespace kt {
namespace {

/// What a patch is not made for; the path of a device that yields is known when it is over.
void find_speed(const Scene& scene, const ToolRun& run, std::size_t k, std::vector<Finding>& out) {
  const double h = 1 / scene.local.rate_hz;
  const auto& frames = run.frames;
  int count = 0;
  std::size_t fastest = 0;
  double most = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const double speed = (frames[i].pose.x - (i > 0 ? frames[i - 1].pose.x : run.start.x)).norm() / h;
    count += speed > kFollowedSpeed;
    if (speed <= most) continue;
    most = speed;
    fastest = i;
  }
  if (count == 0) return;
  out.push_back(Finding{
      told(k == 0 ? "tool.path" : "second_tool.path", ": too fast in ", count, " of ", frames.size(),
           " ticks, most of all in tick ", fastest, " (t = ", frames[fastest].t, " s) with ", most, " m/s, ", most * h,
           " m in one tick: local models are made for up to ", kFollowedSpeed, " m/s, contact beyond is coarse"),
      {advise("give the path more time there")}}
                    .at(k == 0 ? "tool.path" : "second_tool.path", most, kFollowedSpeed));
}

/// What a limit cycle feeds on. Pressing at rest the hold gives next to nothing.
void find_activity(const Scene& scene, const ToolRun& run, std::size_t k, std::vector<Finding>& out) {
  constexpr double kShare = 0.5;  // of the largest energy that the hand had put in
  if (!run.passivity) return;
  const PassivityRun& p = *run.passivity;
  if (!(p.least < -kShare * p.most || p.most_debt > kShare * p.most)) return;
  Finding found{told(which(k), "the haptic loop gave the hand energy: holding the force over a tick gave ",
                     1e3 * p.most_debt, " mJ that nothing took back, the hand had put in ", 1e3 * p.most,
                     " mJ at most: expect a limit cycle")};
  found = std::move(found).at(tool_key(k), p.most_debt, kShare * p.most);
  if (!run.device) found.cures.push_back(advise("raise tool.path.hand.damping"));
  found.cures.push_back(advise("raise local.rate_hz"));
  found.cures.push_back(
      advise(scene.local.passivity_damping > 0 ? "raise local.passivity_damping" : "set local.passivity_damping"));
  out.push_back(std::move(found));
}

}  // namespace

void find_in_motion(const Scene& scene, const SessionResult& result, std::vector<Finding>& out) {
  for (std::size_t k = 0; k < result.tools.size(); ++k) {
    find_speed(scene, result.tools[k], k, out);
    find_activity(scene, result.tools[k], k, out);
  }
}

}  // namespace kt
