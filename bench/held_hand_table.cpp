// A simulated hand that presses scenes/organ_springs.json's organ and holds still, over a link with delay and loss:
// whether it comes to rest. In lockstep, where link.latency_ms is all that lies between a refresh and its model: half
// of it each way over a network.
//   build/release/bench/held_hand_table [DAMPING[,...] [LATENCY_MS[,...] [LOSS[,...] [KEY=VALUE...]]]]
#include <cstdio>
#include <sstream>

#include "haptics/session/session.hpp"

namespace kt {
namespace {

constexpr double kPressed = 0.3, kEnd = 3;  // [s]
constexpr double kStill = 5e-5;             // [m] to and fro, below which nobody feels a swing

/// Up to kPressed as the drag of the scene does, and no further.
Scene held(double damping, double latency_ms, double loss, const std::vector<std::string>& settings) {
  Scene scene = load_scene(KT_SOURCE_DIR "/scenes/organ_springs.json", settings);
  const std::vector<TimedPoint> drag = Session(scene).path();
  SceneHand hand{.damping = damping, .target = {}};
  for (const TimedPoint& p : drag)
    if (p.t <= kPressed) hand.target.push_back({p.t, p.x});
  const Vec3 deeper(0, 0, -1e-3);  // [m] than the drag: the hand yields by as much
  hand.target.push_back({kPressed + 0.05, hand.target.back().position + deeper});
  scene.duration = kEnd;
  scene.tool.path.press_drag.reset();
  scene.tool.path.hand = hand;
  scene.link.latency_ms = latency_ms;
  scene.link.loss = loss;
  return scene;
}

/// Largest less smallest of any coordinate of the tool [m].
double swing(std::span<const LocalFrame> frames, std::size_t begin, std::size_t end) {
  Vec3 low = frames[begin].pose.x, high = low;
  for (std::size_t i = begin; i < end; ++i) {
    low = low.cwiseMin(frames[i].pose.x);
    high = high.cwiseMax(frames[i].pose.x);
  }
  return (high - low).maxCoeff();
}

void row(double damping, double control, double latency_ms, double loss, std::vector<std::string> settings) {
  settings.push_back(text("local.passivity_damping=", control));
  Session session(held(damping, latency_ms, loss, settings));
  const SessionResult run = session.run();
  const std::span<const LocalFrame> frames = run.tools[0].frames;
  constexpr std::size_t kWindow = 250;  // ticks: two swings of a hand of 0.1 kg on 300 N/m
  std::size_t still = frames.size();
  while (still >= kWindow && swing(frames, still - kWindow, still) < kStill) still -= 10;
  const bool settles = still < frames.size();
  std::printf("%7g %7g | %6g %7g %4g |", damping, control, 0.5 * latency_ms, latency_ms, 100 * loss);
  for (const double from : {0.35, 0.75, 1.25, 1.75, 2.75}) {
    const auto begin = static_cast<std::size_t>(from * 1000);
    std::printf(" %6.3f", 1e3 * swing(frames, begin, begin + kWindow));
  }
  if (settles)
    std::printf(" | %6.2f", static_cast<double>(still) / 1000 - kPressed - 0.05);
  else
    std::printf(" |   none");
  std::printf(" | %6.4f %6d %6d\n", frames.back().force.norm(), run.tools[0].missed_impacts, run.last_patch_vertices);
  std::fflush(stdout);
}

std::vector<double> numbers(const std::string& list) {
  std::vector<double> out;
  std::istringstream in(list);
  for (std::string one; std::getline(in, one, ',');) out.push_back(std::stod(one));
  return out;
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) {
  const auto list = [&](int i, const char* usual) { return kt::numbers(argc > i ? argv[i] : usual); };
  const std::vector<std::string> settings(argv + std::min(argc, 4), argv + argc);
  std::printf(
      "   hand control |   each latency loss |        swing [mm] from [s], 0.25 s each | still  |  force missed  "
      "patch\n"
      "  N s/m   N s/m | way ms      ms    %% |   0.35   0.75   1.25   1.75   2.75 | after s|      N  ticks nodes\n");
  for (const double damping : list(1, "0.5,3"))
    for (const double control : {0.0, 20.0})
      for (const double latency : list(2, "0,100,200,400"))
        for (const double loss : list(3, "0.2")) kt::row(damping, control, latency, loss, settings);
}
