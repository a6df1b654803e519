// What is predicted of ticks in contact, over what they take: medians over the ticks that touch in a run in lockstep,
// of the prediction at the refresh before each tick, of the one at set-up, and of the CPU time. Runs of one scene are
// the same to the bit, so the least time of each tick over several runs is the tick's: the rest is the scheduler's.
//   build/release/bench/tick_prediction_table [--runs N] [SCENE.json [KEY=VALUE...]]...
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <string>

#include "core/base/error.hpp"
#include "core/base/percentile.hpp"
#include "haptics/halves/body_side.hpp"
#include "haptics/session/session.hpp"
#include "haptics/touch/touch.hpp"
#include "haptics/touch/touch_halves.hpp"

namespace kt {
namespace {

struct Case {
  std::string file;
  std::vector<std::string> settings;
};

/// A tick in contact.
struct Tick {
  double us = 0, predicted_us = 0;
  int places = 0;
};

/// Ticks of a run, with what was predicted of them.
class Follower final : public SessionWatcher {
 public:
  void begun(Touch& touch) override { touch_ = &touch; }
  void ticked(std::span<const LocalFrame> frames, double us, long long /*allocations*/) override {
    const ReducerChoice& choice = TouchHalves::slow(*touch_).refresher().choice();
    if (ticks.empty()) at_set_up = choice.chosen().tick_us;
    Tick& tick = ticks.emplace_back(us, choice.chosen().tick_us);
    for (const LocalFrame& frame : frames) tick.places += frame.contacts;
  }
  std::vector<Tick> ticks;
  double at_set_up = 0;

 private:
  Touch* touch_ = nullptr;
};

template <class Of>
double median_of(const std::vector<Tick>& ticks, const Of& of) {
  std::vector<double> out;
  for (const Tick& tick : ticks)
    if (tick.places > 0) out.push_back(of(tick));
  return percentile(out, 0.5);
}

void print_row(const Case& of, int runs) {
  Scene scene = load_scene(of.file, of.settings);
  scene.link = LinkSettings();
  Session session(scene);
  Follower first;
  SessionResult result;
  for (int k = 0; k < runs; ++k) {
    Follower again;
    SessionOptions options;
    options.check_contacts = false;
    options.watcher = k == 0 ? &first : &again;
    result = session.run(options);
    for (std::size_t i = 0; i < again.ticks.size(); ++i)
      first.ticks[i].us = std::min(first.ticks[i].us, again.ticks[i].us);
  }
  const double measured = median_of(first.ticks, [](const Tick& t) { return t.us; });
  const double predicted = median_of(first.ticks, [](const Tick& t) { return t.predicted_us; });
  const double places = median_of(first.ticks, [](const Tick& t) { return t.places; });
  std::string name = of.file.substr(of.file.find_last_of('/') + 1);
  name.resize(name.size() - std::string(".json").size());
  for (const std::string& setting : of.settings) name += ", " + setting;
  std::printf("| %s | %s, %d | %s | %.0f | %.0f | %.0f | %.0f | %.2f |\n", name.c_str(), result.reducer.c_str(),
              result.last_dof, result.refresh.fineness.empty() ? "no" : "yes", places, measured, first.at_set_up,
              predicted, predicted / measured);
  std::fflush(stdout);
}

std::vector<Case> usual_cases() {
  std::vector<Case> out;
  for (const char* name :
       {"organ_drag", "organ_springs", "slab_drag", "first_touch", "capsule_drag", "organ_swing", "palpation",
        "two_blocks", "two_hands", "gallery/finger", "gallery/known_law", "gallery/lump", "gallery/membrane",
        "gallery/organ", "gallery/skin_over_bone", "gallery/stylus", "gallery/tube", "paper_stick_slip"})
    out.push_back({text(KT_SOURCE_DIR "/scenes/", name, ".json"), {}});
  for (const char* rings : {"local.rings=2", "local.rings=3", "local.rings=4"})
    for (const char* refine : {"local.refine=auto", "local.refine=off"})
      out.push_back({KT_SOURCE_DIR "/scenes/organ_drag.json", {"local.reducer=wall", rings, refine, "duration=0.6"}});
  return out;
}

}  // namespace
}  // namespace kt

int main(int argc, char** argv) try {
  int runs = 3;
  std::vector<std::string> words;
  CLI::App app("CPU time of a tick in contact, predicted over measured");
  app.add_option("--runs", runs, "of each, of which the smallest counts tick by tick")->check(CLI::PositiveNumber);
  app.add_option("scenes", words, "each with its settings behind it; none: the usual ones");
  CLI11_PARSE(app, argc, argv);
  std::vector<kt::Case> cases;
  for (const std::string& word : words) {
    if (word.ends_with(".json"))
      cases.push_back({word, {}});
    else if (!cases.empty())
      cases.back().settings.push_back(word);
  }
  if (cases.empty()) cases = kt::usual_cases();
  std::puts("| scene | reducer, coordinates | refined | places | measured us | at set-up us | predicted us | over |");
  std::puts("|---|---|---|---|---|---|---|---|");
  for (const kt::Case& of : cases) kt::print_row(of, runs);
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
