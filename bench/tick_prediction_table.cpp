// What is predicted of a tick in contact, over what it takes: the reducer in use at the end of a run in lockstep, its
// prediction at set-up, and the median CPU time of the ticks that touch. Runs of one scene are the same to the bit, so
// the least time of each tick over several runs is the tick's: the rest is the scheduler's.
//   build/release/bench/tick_prediction_table [--runs N] [SCENE.json [KEY=VALUE...]]...
#include <algorithm>
#include <cstdio>
#include <string>

#include "core/base/error.hpp"
#include "core/base/percentile.hpp"
#include "haptics/session/session.hpp"

namespace kt {
namespace {

struct Case {
  std::string file;
  std::vector<std::string> settings;
};

/// CPU time of each tick [us], the least of all runs.
std::vector<double> tick_times(Session& session, int runs, SessionResult& last) {
  SessionOptions options;
  options.check_contacts = false;
  std::vector<double> out;
  for (int k = 0; k < runs; ++k) {
    last = session.run(options);
    if (out.empty()) out.assign(last.step_us.begin(), last.step_us.end());
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = std::min(out[i], last.step_us[i]);
  }
  return out;
}

void print_row(const Case& of, int runs) {
  Scene scene = load_scene(of.file, of.settings);
  scene.link = LinkSettings();
  Session session(scene);
  SessionResult result;
  const std::vector<double> us = tick_times(session, runs, result);
  std::vector<double> touching, places;
  for (std::size_t i = 0; i < us.size(); ++i) {
    int held = 0;
    for (const ToolRun& tool : result.tools) held += tool.frames[i].contacts;
    if (held == 0) continue;
    touching.push_back(us[i]);
    places.push_back(held);
  }
  const auto chosen = std::ranges::find(result.reducer_candidates, result.reducer_name, &ReducerCandidate::name);
  if (chosen == result.reducer_candidates.end()) throw RunError("the reducer at the end is none of the candidates");
  const double measured = percentile(touching, 0.5), predicted = chosen->tick_us;
  std::string name = of.file.substr(of.file.find_last_of('/') + 1);
  name.resize(name.size() - std::string(".json").size());
  for (const std::string& setting : of.settings) name += ", " + setting;
  std::printf("| %s | %s | %d | %s | %.0f | %.0f | %.0f | %.2f |\n", name.c_str(), result.reducer.c_str(), chosen->dof,
              result.refresh.fineness.empty() ? "no" : "yes", percentile(places, 0.5), predicted, measured,
              predicted / measured);
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

int main(int argc, char** argv) {
  int runs = 3;
  std::vector<kt::Case> cases;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--runs" && i + 1 < argc)
      runs = std::stoi(argv[++i]);
    else if (word.ends_with(".json"))
      cases.push_back({word, {}});
    else if (!cases.empty())
      cases.back().settings.push_back(word);
  }
  if (cases.empty()) cases = kt::usual_cases();
  std::puts("| scene | reducer | coordinates | refined | places | predicted us | measured us | predicted / measured |");
  std::puts("|---|---|---|---|---|---|---|---|");
  for (const kt::Case& of : cases) kt::print_row(of, runs);
}
