// What a link's delay and loss cost: the size of local models, the time of their refreshes, the force against the same
// run at once. In lockstep, where link.latency_ms is all that lies between a refresh and its model: half of it each way
// over a network. The same tool path some millimetres apart for each seed, since one drag alone can go two ways.
//   build/release/bench/link_delay_table drag|rub|hand [SEEDS [LATENCY_MS[,...] [LOSS[,...] [KEY=VALUE...]]]]
#include <cstdio>
#include <random>
#include <sstream>

#include "haptics/halves/haptic_side.hpp"
#include "haptics/session/metrics.hpp"
#include "haptics/session/session.hpp"
#include "haptics/touch/touch.hpp"
#include "haptics/touch/touch_halves.hpp"
#include "lab/study/reference.hpp"

namespace kt {
namespace {

/// The local models as they come into use.
class Sizes final : public SessionWatcher {
 public:
  void begun(Touch& touch) override { touch_ = &touch; }
  void ticked(std::span<const LocalFrame> frames, double, long long) override {
    if (frames[0].model_frame == frame_) return;
    frame_ = frames[0].model_frame;
    const LocalModel& model = TouchHalves::fast(*touch_).model().model;
    dof.push_back(model.dof());
    vertices.push_back(model.patch.num_vertices());
  }
  void ended() override { touch_ = nullptr; }
  std::vector<double> dof, vertices;

 private:
  const Touch* touch_ = nullptr;
  int frame_ = -1;
};

struct Run {
  std::vector<Vec3> force;
  std::vector<double> dof, vertices, cpu_ms;
  double refreshes = 0, edge = 0, missed = 0, inside = 0, largest_step = 0;
};

Run run(const Scene& scene, const std::vector<TimedPoint>& path, bool is_unbounded) {
  Session session(scene);
  if (!path.empty()) session.follow(path);
  SessionOptions options;
  if (is_unbounded) options.max_speeds = {std::numeric_limits<double>::infinity()};
  Sizes sizes;
  options.watcher = &sizes;
  const SessionResult result = session.run(options);
  Run out{tick_forces(result.tools[0].frames), sizes.dof, sizes.vertices, result.refresh.cpu_ms};
  out.refreshes = static_cast<double>(result.refreshes.size()) / scene.duration;
  out.missed = result.tools[0].missed_impacts;
  for (const double depth : result.tools[0].penetration) out.inside += depth > 1e-4;
  for (std::size_t i = 0; i < out.force.size(); ++i) {
    out.edge += (result.tools[0].frames[i].flags & kLeftPatch) != 0;
    if (i > 0) out.largest_step = std::max(out.largest_step, (out.force[i] - out.force[i - 1]).norm());
  }
  return out;
}

/// To and fro along the way of the drag, at up to `speed` [m/s].
std::vector<TimedPoint> rubbed(const std::vector<TimedPoint>& drag, double pressed, double duration, double speed) {
  constexpr double kWay = 0.016;  // [m] to each side
  double end = drag.back().t;
  const double mean = (drag.back().x - interpolate_path(drag, pressed)).norm() / (end - pressed);
  const double middle = pressed + kWay / mean;
  std::vector<TimedPoint> out;
  for (double t = 0; t <= duration + 1e-9; t += 0.001) {
    const double at = t < pressed ? t : middle - kWay / mean * std::cos(speed / kWay * (t - pressed));
    out.push_back({t, interpolate_path(drag, std::min(at, end))});
  }
  return out;
}

std::vector<double> numbers(const std::string& list) {
  std::vector<double> out;
  std::istringstream in(list);
  for (std::string one; std::getline(in, one, ',');) out.push_back(std::stod(one));
  return out;
}

struct Case {
  std::string kind;
  int seeds = 4;
  std::vector<double> latency_ms{0, 50, 100, 200, 400}, loss{0, 0.2};
  std::vector<std::string> settings{};
};

/// The scene of one seed, and the path that its tool follows; none: the scene's.
std::pair<Scene, std::vector<TimedPoint>> seeded(const Case& which, int seed) {
  Scene scene = load_scene(KT_SOURCE_DIR "/scenes/organ_drag.json", which.settings);
  PressDrag drag = *scene.tool.path.press_drag;
  const double duration = scene.duration;
  if (which.kind == "rub") scene.duration = 2.5;
  const Vec3 at = interpolate_path(Session(scene).path(), drag.press_time);
  std::mt19937_64 random(static_cast<std::uint64_t>(seed));
  const auto off = [&] { return 2e-3 * (static_cast<double>(random() >> 11) * 0x1p-53 - 0.5); };
  drag.at = std::array<double, 2>{at.x() + off(), at.y() + off()};
  scene.tool.path.press_drag = drag;
  const std::vector<TimedPoint> path = Session(scene).path();
  scene.duration = duration;
  scene.seed = static_cast<std::uint64_t>(seed);
  if (which.kind == "rub") return {scene, rubbed(path, drag.press_time, duration, 0.2)};
  if (which.kind != "hand") return {scene, {}};
  SceneHand hand{.damping = 3, .target = {}};
  for (const TimedPoint& p : path) hand.target.push_back({p.t, p.x});
  scene.tool.path.press_drag.reset();
  scene.tool.path.hand = hand;
  return {scene, {}};
}

void print(double latency_ms, double loss, const std::vector<Run>& runs, const std::vector<Run>& at_once) {
  std::vector<double> dof, vertices, ms, error, step, step_before, jump;
  double refreshes = 0, edge = 0, missed = 0, inside = 0;
  const auto add = [](std::vector<double>& to, const std::vector<double>& from) {
    to.insert(to.end(), from.begin(), from.end());
  };
  for (std::size_t s = 0; s < runs.size(); ++s) {
    add(dof, runs[s].dof);
    add(vertices, runs[s].vertices);
    add(ms, runs[s].cpu_ms);
    error.push_back(100 * compare_forces(runs[s].force, at_once[s].force).force_error);
    step.push_back(1e3 * runs[s].largest_step);
    jump.push_back(runs[s].largest_step / at_once[s].largest_step);
    refreshes += runs[s].refreshes / static_cast<double>(runs.size());
    edge += 100 * runs[s].edge / static_cast<double>(runs.size() * runs[s].force.size());
    missed += runs[s].missed;
    inside += runs[s].inside;
  }
  const auto most = [](const std::vector<double>& v) { return *std::ranges::max_element(v); };
  std::printf(
      "%6g %8g %5g | %4.0f %4.0f %4.0f %4.0f | %6.1f %6.1f %5.0f | %5.1f %5.0f %5.0f | %6.2f %6.2f | %6.1f %6.1f "
      "%5.2f\n",
      0.5 * latency_ms, latency_ms, 100 * loss, percentile(vertices, 0.5), most(vertices), percentile(dof, 0.5),
      most(dof), percentile(ms, 0.5), percentile(ms, 0.9), refreshes, edge, missed, inside, percentile(error, 0.5),
      most(error), percentile(step, 0.5), most(step), percentile(jump, 0.5));
  std::fflush(stdout);
}

void table(const Case& which) {
  std::printf(
      "%s, %d seeds\n  each  latency  loss |  vertices  coordinates | refresh CPU ms    Hz |  edge missed inside | "
      "force off %%  |  step mN        x\n"
      "way ms       ms     %% | med  most  med most |    med    p90       |     %% ticks ticks | median   most | "
      "median   most  once\n",
      which.kind.c_str(), which.seeds);
  std::vector<Run> at_once;
  std::vector<std::pair<Scene, std::vector<TimedPoint>>> scenes;
  for (int seed = 1; seed <= which.seeds; ++seed) scenes.push_back(seeded(which, seed));
  for (auto& [scene, path] : scenes) at_once.push_back(run(scene, path, which.kind != "drag"));
  for (const double latency : which.latency_ms)
    for (const double loss : which.loss) {
      std::vector<Run> runs;
      for (auto [scene, path] : scenes) {
        scene.link.latency_ms = latency;
        scene.link.loss = loss;
        const bool is_known = latency == 0 && loss == 0;
        runs.push_back(is_known ? at_once[runs.size()] : run(scene, path, which.kind != "drag"));
      }
      print(latency, loss, runs, at_once);
    }
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  kt::Case which{.kind = argc > 1 ? argv[1] : "drag"};
  if (argc > 2) which.seeds = std::atoi(argv[2]);
  if (argc > 3) which.latency_ms = kt::numbers(argv[3]);
  if (argc > 4) which.loss = kt::numbers(argv[4]);
  for (int i = 5; i < argc; ++i) which.settings.push_back(argv[i]);
  kt::table(which);
}
