// What "auto" takes: by hand on made-up candidates, and for bodies that need different local models.
#include "haptics/options/band_powers.hpp"
#include "haptics/refresh/reducer_choice.hpp"

#include <gtest/gtest.h>

#include "models/model.hpp"
#include "tests/support/contact_site.hpp"
#include "tests/support/meshes.hpp"

namespace kt {
namespace {

ReducerCandidate made_up(double error, double tick_us) {
  ReducerCandidate out;
  out.error = out.force_error = error;
  out.tick_us = out.cost_us = tick_us;
  return out;
}

TEST(ChooseReducer, TakesTheCheapestWithinToleranceAndBudget) {
  const std::vector<ReducerCandidate> c{made_up(0.5, 10), made_up(0.04, 30), made_up(0.03, 25), made_up(0.001, 90)};
  EXPECT_EQ(choose_reducer(c, {0.05, 200}), 2u);
  EXPECT_EQ(choose_reducer(c, {0.01, 200}), 3u);
  EXPECT_EQ(choose_reducer(c, {0.6, 200}), 0u);
}

TEST(ChooseReducer, PrefersTheMoreAccurateOfThoseThatCostAlike) {
  EXPECT_EQ(choose_reducer(std::vector{made_up(0.04, 30), made_up(0.01, 32.9), made_up(0.001, 33.1)}, {0.05, 200}), 1u);
  EXPECT_EQ(choose_reducer(std::vector{made_up(0.01, 32.9), made_up(0.04, 30)}, {0.05, 200}), 0u);
  EXPECT_EQ(choose_reducer(std::vector{made_up(0.01, 32.9), made_up(0.04, 30)}, {0.05, 31}), 1u) << "the budget wins";
}

TEST(ChooseReducer, LetsTheBudgetWinOverTheTolerance) {
  const std::vector<ReducerCandidate> c{made_up(0.5, 10), made_up(0.2, 30), made_up(0.001, 90)};
  EXPECT_EQ(choose_reducer(c, {0.05, 50}), 1u);
  EXPECT_EQ(choose_reducer(c, {0.05, 5}), 0u);  // nothing fits: the cheapest
}

/// By hand: a right triangle of 3, 4 and 5, and one whose longest side is a quarter longer than the other.
TEST(ChooseReducer, LeavesALocalModelWhatTheCellsLeaveOfTheTolerance) {
  EXPECT_NEAR(model_tolerance(0.05, 0.03), 0.04, 1e-15);
  EXPECT_NEAR(model_tolerance(0.05, 0.12), 0.09, 1e-15) << "0.15 in all";
  EXPECT_EQ(model_tolerance(0.05, 0), 0.05);
}

ReducerCandidate with_refresh(double error, double refresh_ms) {
  ReducerCandidate out = made_up(error, 10 + refresh_ms);
  out.refresh_ms = refresh_ms;
  return out;
}

TEST(ChooseReducer, KeepsToTheBudgetOfTheRefresh) {
  const std::vector<ReducerCandidate> c{with_refresh(0.5, 3), with_refresh(0.2, 20), with_refresh(0.01, 60)};
  EXPECT_EQ(choose_reducer(c, {.tolerance = 0.05}), 2u) << "any will do";
  EXPECT_EQ(choose_reducer(c, {.tolerance = 0.05, .refresh_budget_ms = 26.7}), 1u) << "the best of those within it";
  EXPECT_EQ(choose_reducer(c, {.tolerance = 0.05, .refresh_budget_ms = 1}), 0u) << "the nearest to it";
  std::vector<ReducerCandidate> stiff{with_refresh(0.04, 20), with_refresh(0.1, 25)};
  stiff[0].errors = {0.6};
  EXPECT_EQ(choose_reducer(stiff, {.tolerance = 0.05, .refresh_budget_ms = 26.7}), 1u) << "twice as often is no relief";
  const std::vector<ReducerCandidate> slow{with_refresh(0.5, 30), with_refresh(0.02, 40), with_refresh(0.01, 60)};
  EXPECT_EQ(choose_reducer(slow, {.tolerance = 0.05, .refresh_budget_ms = 20}), 1u) << "none is in time: hardly later";
  EXPECT_EQ(choose_reducer(c, {.tolerance = 0.05, .budget_us = 40, .refresh_budget_ms = 100}), 1u);
  const std::vector<ReducerCandidate> late{with_refresh(0.17, 10), with_refresh(0.03, 27), with_refresh(0.01, 38)};
  EXPECT_EQ(choose_reducer(late, {.tolerance = 0.05, .refresh_budget_ms = 26.7}), 1u) << "right, and hardly late";
  EXPECT_EQ(choose_reducer(late, {.tolerance = 0.05, .refresh_budget_ms = 15}), 0u) << "too late to be right";
}

struct BlockOptions {
  int x = 6, y = 6, z = 4;
  double edge = 5e-3, young = 1e4;
  bool clamped = true;
  double across = 0.5;  // of its width: where it is touched
};

/// A block at rest with its base clamped, touched in the middle of its top.
struct TouchedBlock {
  explicit TouchedBlock(const BlockOptions& o) {
    const Mesh mesh = kuhn_block(o.x, o.y, o.z, o.edge);
    ModelOptions physics;
    physics.young = o.young;
    physics.poisson = 0.4;
    physics.damping_mass = 0;
    physics.damping_stiffness = 2e-3;
    physics.material = "neo_hookean";
    if (o.clamped) physics.fixed_nodes = nodes_below(mesh, 1e-6);
    model = make_model("fem", mesh, physics);
    tangent = linearize(*model, rest_state(*model));
    const Surface surface = make_surface(mesh);
    const Vec3 top = o.edge * Vec3(o.across * o.x + 0.1, 0.5 * o.y + 0.2, o.z);
    site = site_near(surface, mesh.x, top, 0.3 * o.edge);
    patch = make_patch(surface, tangent.state.x, site);
  }
  ReducerChoice choice(double tolerance, double budget_us = 200) const {
    ReducerChoice out("auto", 1, {tolerance, budget_us});
    out.set_up(tangent, patch, site);
    return out;
  }
  ReducerChoice choice(const ReducerNeeds& needs) const {
    ReducerChoice out("auto", 1, needs);
    out.set_up(tangent, patch, site);
    return out;
  }
  std::unique_ptr<DeformableModel> model;
  TangentModel tangent;
  SurfacePatch patch;
  ContactSite site;
};

constexpr double kTolerance = 0.05;

TEST(AutoReducer, TakesDifferentModelsForDifferentBodies) {
  const BlockOptions soft{.young = 4e3}, stiff{.young = 3e6}, thin{.x = 8, .y = 8, .z = 1},
      fine{.x = 14, .y = 14, .z = 7, .edge = 2e-3};
  std::map<std::string, int> names;
  for (const auto& [what, options] : {std::pair("soft", soft), {"stiff", stiff}, {"thin", thin}, {"fine", fine}}) {
    const ReducerChoice choice = TouchedBlock(options).choice(kTolerance);
    std::printf("%s: %s\n", what, choice.reason().c_str());
    EXPECT_LE(choice.certified_error(), kTolerance) << what;
    EXPECT_LE(choice.chosen().tick_us, 200) << what;
    ++names[choice.chosen().name];
  }
  EXPECT_GE(names.size(), 3u);
}

/// A refresh that chooses its nodes anew costs more already.
TEST(Samples, WaitForARefreshThatKeepsItsNodesButNotForLong) {
  const TouchedBlock near({.x = 14, .y = 14, .z = 7, .edge = 2e-3});
  const TouchedBlock far({.x = 14, .y = 14, .z = 7, .edge = 2e-3, .across = 0.9});
  ReducerChoice choice("krylov", 1, {});
  const auto refresh = [&](const TouchedBlock& at) {
    choice.revise(choice.reduce(near.tangent, at.patch, at.site), at.site, 0);
    return !std::isnan(choice.certified_error());
  };
  choice.set_up(near.tangent, near.patch, near.site);
  EXPECT_TRUE(std::isnan(choice.certified_error())) << "nothing asks for it at set-up";
  EXPECT_FALSE(refresh(far)) << "chose its nodes anew";
  EXPECT_TRUE(refresh(far)) << "kept them";

  choice = ReducerChoice("krylov", 1, {});
  choice.set_up(near.tangent, near.patch, near.site);
  int waited = 0;
  while (!refresh(waited % 2 == 0 ? far : near) && waited < 20) ++waited;
  EXPECT_GE(waited, 3);
  EXPECT_LE(waited, 8);
}

TEST(Samples, AreWhatANamedReducerIsCertifiedByWhereThereAreAny) {
  const TouchedBlock block({});
  const double by_auto = block.choice(kTolerance).certified_error();
  for (const char* name : {"krylov", "condensed", "wall"}) {
    ReducerChoice choice(name, 1, {});
    choice.set_up(block.tangent, block.patch, block.site);
    EXPECT_GT(choice.chosen().dof, 0) << name;
    EXPECT_TRUE(std::isnan(choice.certified_error())) << name;
    for (int refresh = 0; refresh < 40; ++refresh)
      choice.revise(choice.reduce(block.tangent, block.patch, block.site), block.site, 0);
    EXPECT_GT(choice.certified_error(), 0) << name;
    if (std::string(name) == "krylov") {
      EXPECT_LE(choice.certified_error(), 10 * by_auto);
    }
  }
  ReducerChoice modal("modal", 1, {});
  modal.set_up(block.tangent, block.patch, block.site);
  EXPECT_GT(modal.certified_error(), 0) << "no samples: certified at once";
}

// A setting that is changed while it runs: what took seconds to find out stays known, of a body that is much as before.
TEST(AutoReducer, GoesOnFromTheSameBodyWithOtherSettings) {
  const auto errors = [](const ReducerChoice& choice) {
    std::vector<double> out;
    for (const ReducerCandidate& c : choice.candidates()) out.push_back(c.error);
    return out;
  };
  const auto after = [](const ReducerChoice& first, const TouchedBlock& body, const ReducerNeeds& needs) {
    ReducerChoice before("auto", 1, {kTolerance, 200}), out("auto", 1, needs);
    const TouchedBlock soft({.young = 1e4});
    before.set_up(soft.tangent, soft.patch, soft.site);
    EXPECT_EQ(before.chosen().name, first.chosen().name);
    out.go_on_from(before);
    out.set_up(body.tangent, body.patch, body.site);
    return out;
  };
  const TouchedBlock soft({.young = 1e4}), firmer({.young = 2e4}), stiff({.young = 1e6});
  const ReducerChoice first = soft.choice(kTolerance);
  const ReducerChoice near = after(first, firmer, {kTolerance, 200});
  EXPECT_EQ(errors(near), errors(first));
  EXPECT_EQ(near.chosen().name, first.chosen().name);
  EXPECT_EQ(errors(after(first, stiff, {kTolerance, 200})), errors(stiff.choice(kTolerance)));
  EXPECT_EQ(errors(after(first, firmer, {0.5 * kTolerance, 200})), errors(firmer.choice(0.5 * kTolerance)));
  EXPECT_NE(errors(first), errors(stiff.choice(kTolerance)));
}

TEST(AutoReducer, ServesABodyThatIsFreeToMove) {
  const TouchedBlock b({.clamped = false});
  ReducerChoice choice = b.choice(kTolerance);
  EXPECT_LE(choice.chosen().error, kTolerance) << choice.reason();
  const LocalModel m = choice.reduce(b.tangent, b.patch, b.site);
  EXPECT_NO_THROW(choice.revise(m, b.site, 0));
}

TEST(AutoReducer, NeverGetsWorseWhenTheToleranceIsHalved) {
  for (const BlockOptions& options : {BlockOptions{}, {.young = 3e6}, {.x = 8, .y = 8, .z = 1}}) {
    const TouchedBlock block(options);
    double before = std::numeric_limits<double>::infinity();
    for (double tolerance = 0.8; tolerance > 1e-3; tolerance /= 2) {
      const double error = block.choice(tolerance).certified_error();
      EXPECT_LE(error, before) << "tolerance " << tolerance;
      before = error;
    }
    EXPECT_LT(before, 0.02);
  }
}

TEST(AutoReducer, SaysSoWhenTheBudgetWins) {
  const ReducerChoice choice = TouchedBlock({}).choice(1e-4, 12);
  EXPECT_LE(choice.chosen().tick_us, 12);
  EXPECT_NE(choice.reason().find("the budget wins"), std::string::npos) << choice.reason();
}

TEST(AutoReducer, GoesOverToABetterModelWhenTheBodyChanges) {
  const TouchedBlock stiff({.young = 3e6}), soft({.young = 2e3});  // of one mesh
  ReducerChoice choice = stiff.choice(kTolerance);
  const std::string at_first = choice.chosen().name;
  for (int refresh = 0; refresh < 120; ++refresh)
    choice.revise(choice.reduce(soft.tangent, soft.patch, soft.site), soft.site, refresh);
  EXPECT_NE(choice.chosen().name, at_first);
  ASSERT_FALSE(choice.changes().empty());
  EXPECT_EQ(choice.changes().front().from, at_first);
  EXPECT_EQ(choice.changes().back().to, choice.chosen().name);
  EXPECT_LE(choice.certified_error(), 1.3 * kTolerance);
}

/// 2 mm deep, and moving a little at one rate.
BandPowers press(std::size_t band, double amplitude) {
  BandPowers out{4e-6, {}};
  out.total += 0.5 * amplitude * amplitude;
  out.changing[band] = 0.5 * amplitude * amplitude;
  return out;
}

TEST(AutoReducer, TakesNoMoreThanTheMotionAsksFor) {
  const TouchedBlock block({});
  const ReducerChoice any = block.choice(kTolerance);
  const ReducerChoice slow = block.choice(ReducerNeeds{.tolerance = kTolerance, .motion = press(0, 2e-4)});
  const ReducerChoice shaken = block.choice(ReducerNeeds{.tolerance = kTolerance, .motion = press(5, 5e-4)});
  std::printf("%s\n%s\n%s\n", any.reason().c_str(), slow.reason().c_str(), shaken.reason().c_str());
  EXPECT_EQ(slow.chosen().reducer, "condensed") << "exact at rest";
  EXPECT_EQ(shaken.chosen().reducer, "krylov");
  EXPECT_EQ(any.chosen().reducer, "krylov") << "of an unknown motion the worst rate counts";
  EXPECT_LE(slow.force_error(), kTolerance);
  EXPECT_GT(slow.certified_error(), 0.2) << "which is that of all rates";
}

TEST(AutoReducer, GoesOverWhenTheForceShakes) {
  const TouchedBlock block({});
  ReducerChoice choice = block.choice(ReducerNeeds{.tolerance = kTolerance, .motion = press(0, 2e-4)});
  ASSERT_EQ(choice.chosen().reducer, "condensed");
  const auto refresh = [&](int tick) {
    choice.revise(choice.reduce(block.tangent, block.patch, block.site), block.site, tick);
  };
  for (int i = 0; i < 6; ++i) refresh(i);
  EXPECT_TRUE(choice.changes().empty());
  Excitation shaken{};
  shaken[5] = 0.4;
  choice.excite(shaken);
  EXPECT_GT(choice.force_error(), kTolerance);
  refresh(33);
  ASSERT_EQ(choice.changes().size(), 1u);
  EXPECT_EQ(choice.changes()[0].tick, 33);
  EXPECT_EQ(choice.changes()[0].from, "condensed");
  EXPECT_EQ(choice.chosen().reducer, "krylov");
  EXPECT_LE(choice.changes()[0].force_error, kTolerance);
}

/// Every refresh takes what its reducer is said to, and the rest of it what is given.
TEST(AutoReducer, StepsDownUnderOverloadAndUpAgain) {
  const TouchedBlock block({});
  ReducerChoice choice =
      block.choice(ReducerNeeds{.tolerance = kTolerance, .refresh_budget_ms = 30, .motion = press(5, 5e-4)});
  ASSERT_EQ(choice.chosen().reducer, "krylov");
  int tick = 0;
  const auto refreshes = [&](int count, double rest_ms, double slower) {
    for (int i = 0; i < count; ++i, tick += 33) {
      const double own = slower * choice.predicted_refresh_ms();
      choice.note_cost(rest_ms + own, own, 0, tick);
    }
  };
  refreshes(20, 5, 0.5);
  EXPECT_TRUE(choice.changes().empty());
  refreshes(2, 5, 21);
  EXPECT_TRUE(choice.changes().empty()) << "two late ones are no overload";
  refreshes(1, 5, 21);
  ASSERT_EQ(choice.changes().size(), 1u) << "from " << choice.predicted_refresh_ms() << " ms";
  const ReducerChange down = choice.changes()[0];
  EXPECT_EQ(down.tick, 22 * 33);
  EXPECT_NE(down.to, down.from);
  EXPECT_GT(down.force_error, kTolerance) << "it says what that costs";
  EXPECT_NE(down.why.find("30 ms are there"), std::string::npos) << down.why;
  refreshes(300, 2, 0.3);
  ASSERT_GE(choice.changes().size(), 2u);
  EXPECT_EQ(choice.chosen().name, down.from) << "up again";

  ReducerChoice replayed =
      block.choice(ReducerNeeds{.tolerance = kTolerance, .refresh_budget_ms = 30, .motion = press(5, 5e-4)});
  replayed.follow(choice.changes());
  for (int t = 0; t < tick; t += 33) {
    replayed.note_cost(1e3, 1e3, 0, t);
    if (t == 22 * 33 || t % (33 * 20) == 0)
      replayed.revise(replayed.reduce(block.tangent, block.patch, block.site), block.site, t);
  }
  EXPECT_EQ(replayed.changes()[0].to, down.to);
}

/// Where what was stepped down to takes as long as what was right, that is gone back to.
TEST(AutoReducer, DoesNotStayWithALessAccurateOneThatIsNoCheaper) {
  const TouchedBlock block({});
  ReducerChoice choice =
      block.choice(ReducerNeeds{.tolerance = kTolerance, .refresh_budget_ms = 30, .motion = press(5, 5e-4)});
  const std::string first = choice.chosen().name;
  const double error = choice.chosen().force_error;
  double most = 0;
  for (int i = 0; i < 100; ++i) {
    choice.note_cost(105, 100, 0, 33 * i);
    most = std::max(most, choice.chosen().force_error);
  }
  EXPECT_GT(most, error) << "stepped down";
  EXPECT_LE(choice.chosen().force_error, error);
  EXPECT_LT(choice.changes().size(), 20u) << "and not to and fro";
}

/// A model that is right and a little late is better than one that is wrong.
TEST(AutoReducer, TakesNoneThatIsWrongForBeingALittleLate) {
  const TouchedBlock block({});
  ReducerChoice choice =
      block.choice(ReducerNeeds{.tolerance = kTolerance, .refresh_budget_ms = 30, .motion = press(5, 5e-4)});
  for (int i = 0; i < 100; ++i) {
    choice.note_cost(37, 32, 0, 33 * i);
    EXPECT_LE(choice.chosen().force_error, kTolerance) << choice.reason();
  }
}

}  // namespace
}  // namespace kt
