// The slow side: where impulses go, held contacts, and what happens when a body blows up.
#include "core/global/global_simulation.hpp"

#include <gtest/gtest.h>

#include "core/base/error.hpp"
#include "models/model.hpp"
#include "tests/support/linear_model.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/numbers.hpp"

namespace kt {
namespace {

constexpr double kRoundoff = 1e-12;

/// One sample a millisecond in [begin, end), random impulses on random triangles.
std::vector<ContactSample> random_history(const Mesh& mesh, double begin, double end, double size) {
  std::vector<ContactSample> out;
  const int count = static_cast<int>(std::lround((end - begin) / 1e-3));
  for (int i = 0; i < count; ++i) {
    const VectorX r = random_vector(7, static_cast<unsigned>(i));
    ContactSample s;
    s.t = begin + 1e-3 * i;
    Vec3 bary = r.head<3>().cwiseAbs();
    bary /= bary.sum();
    s.moves = {mesh.triangles[static_cast<std::size_t>((r[6] + 1) / 2 * static_cast<double>(mesh.triangles.size()))],
               bary};
    s.impulse = size * r.segment<3>(3);
    s.normal = Vec3::UnitZ();
    out.push_back(s);
  }
  return out;
}

Vec3 total_momentum(const DeformableModel& model, const VectorX& v) {
  const VectorX p = model.mass() * v;
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < p.size() / 3; ++i) sum += node(p, i);
  return sum;
}

TEST(GlobalSimulation, HandsEachImpulseToTheBodyOnceHoweverTheTimeIsCut) {
  const auto model = make_model("msd", kuhn_block(2, 2, 2, 0.01), {.young = 2e3, .damping_stiffness = 1e-3});
  const std::vector<ContactSample> history = random_history(model->mesh(), 0, 0.1, 1e-5);
  Vec3 given = Vec3::Zero();
  double size = 0;
  for (const ContactSample& s : history) {
    given += s.impulse;
    size += s.impulse.norm();
  }
  for (const BackendInfo& backend : integrator_backends())
    for (double max_step : {0.1, 0.03, 0.001, 0.0007}) {
      if (!make_integrator(backend.name)->is_dynamic()) continue;
      for (int cuts : {1, 4, 50}) {
        GlobalSimulation simulation(*model, make_integrator(backend.name, {.convergence = 1e-15}), max_step);
        for (int c = 0; c < cuts; ++c) {
          const std::size_t first = 100 * c / cuts, last = 100 * (c + 1) / cuts;
          simulation.advance(1e-3 * static_cast<double>(last), std::span(history).subspan(first, last - first));
          EXPECT_EQ(simulation.state().t, 1e-3 * static_cast<double>(last));
        }
        // Dampers that turn make the tangent unsymmetric, of which the solver sees one half: Newton's method converges
        // linearly, and 0.1 s in one step of this body is at 4e-10 after its 50 iterations (without dampers: roundoff).
        const double allowed = backend.name == "newton_euler" && cuts == 1 ? 1e-9 : kRoundoff;
        EXPECT_LE((total_momentum(*model, simulation.state().v) - given).norm(), allowed * size)
            << backend.name << " " << max_step << " " << cuts;
      }
    }
}

TEST(GlobalSimulation, SpreadsEachImpulseOverTheStepItFellInto) {
  const LinearModel model = oscillator(10, 0.1);
  ContactSample s;
  s.moves = {{0, 0, 0}, Vec3(1, 0, 0)};
  s.impulse = Vec3(0.3, -0.2, 0.1);
  std::vector<ContactSample> history{s, s, s};
  history[0].t = 0.005;
  history[1].t = 0.01;  // on the border: of the later step
  history[2].t = 0.029;
  for (const BackendInfo& backend : integrator_backends()) {
    GlobalSimulation simulation(model, make_integrator(backend.name), 0.0101);
    simulation.advance(0.03, history);
    State by_hand = rest_state(model);
    const auto stepper = make_integrator(backend.name);
    const int steps = std::isfinite(stepper->stable_step({10, 0.1})) ? 3 : 1;
    for (int i = 0; i < steps; ++i) stepper->step(model, s.impulse / 0.01, 0.03 / steps, by_hand);
    EXPECT_LE(relative_error(simulation.state().x, by_hand.x), kRoundoff) << backend.name;
    EXPECT_LE(relative_error(simulation.state().v, by_hand.v), kRoundoff) << backend.name;
  }
}

TEST(GlobalSimulation, StandsStillWhenAskedForThePast) {
  const LinearModel model = oscillator(10, 0.1);
  GlobalSimulation simulation(model, make_integrator("implicit_euler"), 0.01);
  ContactSample s;
  s.moves = {{0, 0, 0}, Vec3(1, 0, 0)};
  s.impulse = Vec3(1, 1, 1);
  simulation.advance(0.02, {&s, 1});
  const State before = simulation.state();
  simulation.advance(0.02, {});
  simulation.advance(0.01, {});
  EXPECT_EQ(simulation.state(), before);
}

TEST(GlobalSimulation, SaysWhatToDoWhenTheBodyBlowsUp) {
  const MatrixX one = MatrixX::Identity(3, 3);
  const LinearModel model(one, 0 * one, -1e6 * one);  // pushes itself apart
  GlobalSimulation simulation(model, make_integrator("symplectic_euler"), 0.01);
  ContactSample s;
  s.moves = {{0, 0, 0}, Vec3(1, 0, 0)};
  s.impulse = Vec3(1, 1, 1);
  try {
    simulation.advance(5, {&s, 1});
    FAIL();
  } catch (const RunError& e) {
    EXPECT_STREQ(e.what(),
                 "the global model left the finite numbers before t = 5 s: soften the model, raise global.rate_hz or "
                 "use global.integrator implicit_euler");
  }
}

struct HeldBlock {
  double young = 5e3;  // Pa
  Mesh mesh = kuhn_block(2, 2, 2, 0.01);
  std::unique_ptr<DeformableModel> model = make_model(
      "msd", mesh,
      {.young = young, .damping_mass = 1, .damping_stiffness = 2e-3, .fixed_nodes = nodes_below(mesh, 1e-6)});
  /// A point of the top triangle (22 23 26), pressed down by `depth`.
  ContactHold hold(double depth, bool sticks) const {
    ContactHold out{{{22, 23, 26}, Vec3(0.5, 0.3, 0.2)}, Vec3::UnitZ(), Vec3::Zero(), sticks};
    out.point = point(mesh.x) - depth * out.normal + (sticks ? Vec3(1e-4, 2e-4, 0) : Vec3(Vec3::Zero()));
    return out;
  }
  static Vec3 point(const VectorX& x) { return 0.5 * node(x, 22) + 0.3 * node(x, 23) + 0.2 * node(x, 26); }
};

TEST(HeldModel, AddsAStiffSpringWhoseTangentIsItsDerivative) {
  const HeldBlock b;
  const std::vector<ContactHold> holds{
      b.hold(1e-3, true), {{{4, 5, 8}, Vec3(0.2, 0.2, 0.6)}, Vec3(1, 2, -2) / 3, Vec3(0.01, 0.01, 0), false}};
  const HeldModel held(*b.model, holds, 300);
  State s = rest_state(*b.model);
  s.x += 1e-3 * random_vector(s.x.size(), 1);
  s.v = 0.1 * random_vector(s.x.size(), 2);
  const auto force = [&](const VectorX& x) {
    VectorX out;
    held.force({0, x, s.v}, out);
    return out;
  };
  VectorX own;
  b.model->force(s, own);
  const Vec3 pull = 300 * (holds[0].point - HeldBlock::point(s.x));
  EXPECT_LE((node(force(s.x), 22) - node(own, 22) - 0.5 * pull).norm(), kRoundoff);
  EXPECT_LE(relative_error(held.tangent(s, TangentKind::exact).dfdx, central_differences(force, s.x, 1e-7)), 1e-6);
  const std::vector<ContactHold> first(holds.begin(), holds.begin() + 1);
  EXPECT_NEAR(HeldModel(*b.model, first, 300).push(s.x), -pull.z(), kRoundoff);
}

/// On a smooth surface a point moves with nodes that no element couples.
TEST(HeldModel, HoldsAPointOfManyNodes) {
  const HeldBlock b;
  ContactHold hold = b.hold(1e-3, true);
  hold.moves = {};
  for (const int i : {18, 20, 22, 24, 26}) hold.moves.add(i, 0.2);
  const HeldModel held(*b.model, {&hold, 1}, 300);
  State s = rest_state(*b.model);
  s.x += 1e-3 * random_vector(s.x.size(), 1);
  const auto force = [&](const VectorX& x) {
    VectorX out;
    held.force({0, x, s.v}, out);
    return out;
  };
  Tangent tangent = held.tangent(s, TangentKind::exact);
  EXPECT_GT(tangent.dfdx.nonZeros(), b.model->tangent(s, TangentKind::exact).dfdx.nonZeros());
  EXPECT_LE(relative_error(tangent.dfdx, central_differences(force, s.x, 1e-7)), 1e-6);
  held.update_tangent(s, TangentKind::exact, tangent);  // into its own storage
  EXPECT_LE(relative_error(tangent.dfdx, central_differences(force, s.x, 1e-7)), 1e-6);
  b.model->update_tangent(s, TangentKind::exact, tangent);
  EXPECT_LE(relative_error(tangent.dfdx, MatrixX(b.model->tangent(s, TangentKind::exact).dfdx)), 1e-15);
}

TEST(HeldModel, LeavesTheSparsityOfTheTangentAsItIs) {
  const HeldBlock b;
  const std::vector<ContactHold> holds{b.hold(1e-3, true)};
  const State s = rest_state(*b.model);
  const SparseMatrix own = b.model->tangent(s, TangentKind::definite).dfdx;
  const SparseMatrix held = HeldModel(*b.model, holds, 300).tangent(s, TangentKind::definite).dfdx;
  EXPECT_TRUE(held.isCompressed());
  EXPECT_EQ(held.nonZeros(), own.nonZeros());
}

TEST(GlobalSimulation, BringsAHeldPointToWhereTheToolLeftIt) {
  const HeldBlock b;
  for (bool sticks : {false, true}) {
    GlobalSimulation simulation(*b.model, make_integrator("implicit_euler"), 0.1);
    const ContactHold hold = b.hold(1e-3, sticks);
    for (int i = 1; i <= 20; ++i) simulation.advance(0.1 * i, {}, {&hold, 1});
    const Vec3 miss = HeldBlock::point(simulation.state().x) - hold.point;
    EXPECT_LE(std::abs(miss.z()), 5e-6) << sticks;  // a few tenths of a newton over 1e5 N/m
    EXPECT_GE(miss.z(), 0) << sticks;               // the body pushes back
    EXPECT_TRUE(!sticks || miss.norm() <= 5e-6);
  }
}

/// Springs of one stiffness for all bodies gave way in the body's place from 1e6 Pa on.
TEST(GlobalSimulation, HoldsAStiffBodyAsItHoldsASoftOne) {
  constexpr double kDepth = 1e-3;
  for (const double young : {5e3, 1e6, 1e8, 1e9}) {
    const HeldBlock b{young};
    GlobalSimulation simulation(*b.model, make_integrator("implicit_euler"), 0.1);
    const ContactHold hold = b.hold(kDepth, false);
    for (int i = 1; i <= 20; ++i) simulation.advance(0.1 * i, {}, {&hold, 1});
    const double miss = HeldBlock::point(simulation.state().x).z() - hold.point.z();
    EXPECT_LE(miss, 0.005 * kDepth) << young;
    EXPECT_GE(miss, 0) << young;
  }
}

TEST(GlobalSimulation, FollowsTheHistoryInsteadOfAHoldThatWouldHaveToPull) {
  const HeldBlock b;
  const std::vector<ContactSample> history = random_history(b.mesh, 0, 0.05, 1e-6);
  GlobalSimulation with(*b.model, make_integrator("implicit_euler"), 0.02),
      without(*b.model, make_integrator("implicit_euler"), 0.02);
  const ContactHold above = b.hold(-1e-3, false);
  with.advance(0.05, history, {&above, 1});
  without.advance(0.05, history);
  EXPECT_EQ(with.state(), without.state());
}

TEST(GlobalSimulation, CallsALocalForceWhollyWrongWhereTheBodyWouldHaveToBePulled) {
  const HeldBlock b;
  GlobalSimulation simulation(*b.model, make_integrator("implicit_euler"), 0.02);
  ContactHold above = b.hold(-1e-3, false);
  above.force = 0.2;
  simulation.advance(0.05, {}, {&above, 1});
  EXPECT_EQ(simulation.contact_error(), -1);
  above.force = 0;  // the local model gave none either
  simulation.advance(0.1, {}, {&above, 1});
  EXPECT_EQ(simulation.contact_error(), 0);
}

}  // namespace
}  // namespace kt
