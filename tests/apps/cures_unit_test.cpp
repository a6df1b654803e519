// Every finding that there is, in scenes that are set up in every way that a cure asks for: none is told what it has.
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>

#include "apps/outputs/cures_in_force.hpp"
#include "haptics/cost/force_factor.hpp"
#include "haptics/findings/kinds.hpp"
#include "haptics/predict/predict_contact_method.hpp"
#include "haptics/predict/predict_degenerate_contact.hpp"
#include "haptics/predict/predict_elements.hpp"
#include "haptics/predict/predict_hand.hpp"
#include "haptics/predict/predict_time_step.hpp"
#include "haptics/predict/predict_units.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

/// A tick with every flag in it, a slow body, a tangent that is indefinite, a surface that crosses itself ...
SessionResult everything_wrong() {
  SessionResult r;
  ToolRun& tool = r.tools[0];
  tool.frames.resize(1000, LocalFrame());
  for (std::size_t i = 0; i < 1000; ++i) {
    LocalFrame& f = tool.frames[i];
    f.t = 1e-3 * static_cast<double>(i + 1);
    f.pose.x = Vec3(static_cast<double>(i), 0, 0);
    f.mode = ContactMode::stick;
    f.model_frame = 0;
    f.flags = ~0u;
    f.residual = 1;
    tool.model_force.push_back(Vec3(0, 0, 1));
  }
  tool.penetration.resize(1000, 1e-2);
  tool.limited_forces = 10;
  tool.missed_impacts = 6;
  tool.lost.free_ticks_inside = 5;
  tool.lost.pass_throughs = 1;
  tool.lost.went_through = {{50, 0.4}};
  tool.lost.unchecked_ticks = 2;
  tool.passivity = PassivityRun{.least = -1, .most = 1e-3, .most_debt = 1, .by_hold = 1, .damped_ticks = 1};
  r.step_us.resize(1000, 2000);
  r.lateness_us.resize(1000, 5);
  r.refresh.global_ms.assign(5, 100);
  r.refresh.refresh_ms.assign(5, 100);
  r.refresh.linearization_error = {0.5};
  r.refresh.definite_tangents = 3;
  r.refresh.inverted = {.most = 4, .last = 1, .from = 0.1};
  r.refreshes.resize(5);
  r.global_steps.projected = r.global_steps.not_converged = 1;
  r.self_crossing = {.pairs = 4, .t = 0.1, .at = Vec3::Zero()};
  r.device_lost = r.stopped = true;
  r.reducer = "krylov";
  return r;
}

ForceMetrics bad_force() {
  return {.mean_n = 1, .buzz = 1, .crossing_jump = 1, .refresh_jump = 1, .ticks_stick = 9, .lost_contacts = 3};
}

SceneSizes odd_sizes() {
  SceneSizes s;
  s.body = {Vec3::Zero(), Vec3::Constant(20)};
  s.tool = Vec3::Constant(30);
  s.depth = 1;
  s.thickness = 1;
  return s;
}

/// Of a scene, predicted and found, before anything is left out.
std::vector<Finding> all_kinds(const Scene& scene, const BuiltScene& built) {
  std::vector<Finding> out;
  const auto add = [&](const std::optional<Prediction>& p) {
    if (p) out.push_back(p->finding);
  };
  for (const Prediction& p : predict_units(scene, odd_sizes())) out.push_back(p.finding);
  const ToolMeeting meeting{.speed = 100, .drag = 100, .thickness = 1e-6, .mass = 1e-9};
  add(predict_tunnelling(scene, meeting));
  add(predict_chatter(scene, meeting));
  add(predict_start_inside(0.1, Vec3(0, 0, 0)));
  if (scene.local.integrator == "symplectic_euler")
    add(predict_unstable_step({1e6, 0.1}, scene.local.integrator, 1e-3, "local.integrator"));
  add(predict_locking(built.model(), fitted_element(built.model().info()), scene.object.model.poisson));
  HandLoop loop;
  loop.wall_stiffness = 1e5;
  loop.hand_damping = scene.tool.path.hand ? scene.tool.path.hand->damping : 1;
  add(predict_limit_cycle(loop, scene.local.passivity_damping));
  for (const double factor : {0.5, 2.0}) {
    const ContactWidth width{.cell = 0.005, .contact_radius = 0.003, .mean = 1.7, .factor = factor, .fine_edge = 0.002};
    out.push_back(coarse_mesh_finding(built, width, 0.5));
  }
  SessionResult run = everything_wrong();
  for (const char* reducer : {"krylov", "condensed", "wall", "full"})
    for (const double step_us : {20.0, 5000.0}) {
      run.reducer = reducer;
      run.step_us = {};
      run.step_us.resize(1000, step_us);
      MeasuredRun measured{{bad_force()}, {}, judge_real_time(scene, run)};
      out.push_back({"real time", measured.pace.cures});
      find_old_models(scene, run, measured.pace, out);
      find_withheld_forces(scene, run, out);
      find_in_ticks(scene, run, measured.pace, out);
      find_in_motion(scene, run, out);
      find_in_forces(scene, run, measured, out);
    }
  return out;
}

/// The settings that a cure names: its own, and those in its words.
std::vector<Cure> settings_in(const Cure& cure) {
  std::vector<Cure> out;
  if (!cure.key.empty() && !cure.value.empty()) out.push_back(cure);
  static const std::regex kSet("([a-z_]+\\.[a-z_.]+) to ([A-Za-z0-9_.+-]+)");
  for (std::sregex_iterator i(cure.told.begin(), cure.told.end(), kSet), end; i != end; ++i) {
    std::string value = (*i)[2];
    if (value != "about" && value.find_first_of("0123456789") == 0)
      value = value.substr(0, value.find_last_not_of('.') + 1);
    if (value != "about" && value != "the") out.push_back({(*i)[1], value, cure.told});
  }
  return out;
}

/// Each of the settings that some cure asks for, and what else a cure depends on.
const std::vector<std::vector<std::string>> kScenes{
    {},
    {"contact.surface=loop"},
    {"local.blend_ms=0"},
    {"contact.law=paper_stick"},
    {"local.method=penalty"},
    {"local.method=frozen"},
    {"local.method=hold"},
    {"object.model.type=fem"},
    {"object.model.type=fem", "object.model.element=tet10"},
    {"object.model.type=fem", "object.model.material=linear"},
    {"object.model.young=10"},
    {"object.model.damper=1"},
    {"object.model.poisson=0.45"},
    {"local.integrator=symplectic_euler"},
    {"local.integrator=implicit_euler"},
    {"local.reducer=wall", "local.rings=1"},
    {"local.reducer=wall", "local.rings=3"},
    {"local.passivity_damping=10"},
    {"global.early_refresh=true"},
    {"global.self_contact={}", "global.integrator=newton_euler"},
    {"global.rate_hz=120"},
    {"link.type=thread"},
    {"link.type=lockstep", "link.loss=0.5"},
    {"tool.shape=capsule"},
    {"second_tool={\"shape\": \"sphere\", \"radius\": 0.004}"},
};

TEST(Cures, AreNeverWhatTheSceneHas) {
  int looked_at = 0;
  for (const auto& settings : kScenes) {
    Scene base = small_scene();
    base.object.mesh = KT_SOURCE_DIR "/meshes/block.msh";
    const Scene scene = parse_scene(to_json(base), settings);
    const BuiltScene built(scene);
    for (const Finding& found : all_kinds(scene, built))
      for (const Cure& cure : found.cures)
        for (const Cure& setting : settings_in(cure)) {
          if (setting.key.starts_with("tool.path.hand.")) continue;  // of a hand that these scenes have not
          ++looked_at;
          EXPECT_TRUE(changes(scene, setting)) << ::testing::PrintToString(settings) << '\n'
                                               << found.line() << '\n'
                                               << setting.key << '=' << setting.value;
        }
  }
  EXPECT_GT(looked_at, 500);
}

TEST(Cures, ThatTheSceneHasAreLeftOut) {
  const Scene scene = small_scene();
  const std::vector<Finding> told = with_true_cures(
      scene, {{"a", {set_to("contact.law", "coulomb"), set_to("contact.surface", "loop"), advise("press less deep")}},
              {"b", {set_to("no.such_key", "1"), set_to("contact.mu_static", "-1")}}});
  EXPECT_EQ(told[0].line(), "a; set contact.surface to loop, or press less deep");
  EXPECT_EQ(told[1].line(), "b");
}

}  // namespace
}  // namespace kt
