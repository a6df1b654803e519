// Forces of self-contact against differences of their energy, and steps against what must not happen.
#include "self_contact/barrier.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "bench/pressed_bodies.hpp"
#include "io/surface/mesh_doctor.hpp"
#include "tests/support/numbers.hpp"

namespace kt {
namespace {

TEST(Barrier, SlopeAndBendAreDerivativesOfItsEnergy) {
  const Barrier b{.reach = 2e-3, .stiffness = 50};
  for (double d : {1e-6, 1e-4, 7e-4, 1.9e-3}) {
    const double e = 1e-5 * d;
    EXPECT_NEAR((b.energy(d + e) - b.energy(d - e)) / (2 * e), b.slope(d), 1e-7 * std::abs(b.slope(d)) + 1e-12);
    EXPECT_NEAR((b.slope(d + e) - b.slope(d - e)) / (2 * e), b.bend(d), 1e-7 * b.bend(d) + 1e-9);
    EXPECT_GT(b.energy(d), 0);
    EXPECT_LT(b.slope(d), 0);
    EXPECT_GT(b.bend(d), 0);
  }
  for (double d : {2e-3, 1.0}) EXPECT_EQ(b.energy(d) + b.slope(d) + b.bend(d), 0);
  EXPECT_TRUE(std::isinf(b.energy(0)) && std::isinf(b.slope(0)));
}

/// Two small blocks a tenth of the reach apart, shaken: faces over faces, and parallel edges over one another.
struct Near {
  Near(double gap, double shake)
      : model(make_model("fem",
                         joined({kuhn_block(2, 2, 1, 0.01), placed(kuhn_block(2, 2, 1, 0.01), {0, 0, 0.01 + gap})}),
                         {.young = 1e4})),
        contact(*model, {.reach = 1e-3, .stiffness = 1e3, .mu = 0.5, .creep = 1e-2}),
        state(rest_state(*model)) {
    state.x += shake * random_vector(state.x.size(), 7);
  }
  /// Contact forces alone.
  VectorX force(const TouchingModel& touching, const VectorX& x) const {
    VectorX all, own;
    touching.force({0, x, state.v}, all);
    model->force({0, x, state.v}, own);
    return all - own;
  }
  std::unique_ptr<DeformableModel> model;
  SelfContact contact;
  State state;
};

TEST(TouchingModel, ForceIsTheGradientOfTheBarrier) {
  for (double shake : {1e-4, 1e-5}) {  // the second: edges within the angle at which they count less
    Near near(5e-4, shake);
    near.contact.options.mu = 0;
    const TouchingModel touching(*near.model, near.contact, near.state, 0.01);
    ASSERT_GT(touching.report(near.state.x).contacts, 10);
    const auto energy = [&](const VectorX& x) { return VectorX(VectorX::Constant(1, touching.report(x).energy)); };
    const VectorX gradient = central_differences(energy, near.state.x, 1e-9).transpose();
    touching.report(near.state.x);
    EXPECT_LE(relative_error(near.force(touching, near.state.x), -gradient), 1e-5) << shake;
  }
}

TEST(TouchingModel, FrictionOpposesSlipWithMuTimesTheNormalForce) {
  Near near(5e-4, 0);
  const TouchingModel touching(*near.model, near.contact, near.state, 0.01);
  const double normal = touching.report(near.state.x).normal;
  State slid = near.state;
  const int half = near.model->mesh().num_nodes() / 2;
  for (int i = half; i < 2 * half; ++i) node(slid.x, i).x() += 2e-4;  // more than creep times dt
  touching.free_share(near.state.x, slid.x - near.state.x);
  const VectorX with = near.force(touching, slid.x);
  near.contact.options.mu = 0;
  const TouchingModel smooth(*near.model, near.contact, near.state, 0.01);
  smooth.free_share(near.state.x, slid.x - near.state.x);
  const VectorX friction = with - near.force(smooth, slid.x);
  Vec3 lower = Vec3::Zero(), upper = Vec3::Zero();
  for (int i = 0; i < 2 * half; ++i) (i < half ? lower : upper) += Vec3(node(friction, i));
  EXPECT_NEAR(upper.x(), -0.5 * normal, 1e-9 * normal);
  EXPECT_NEAR((upper + lower).norm(), 0, 1e-12 * normal);
  EXPECT_NEAR(upper.tail<2>().norm(), 0, 1e-9 * normal);
}

TEST(TouchingModel, TangentOfFrictionIsItsDerivative) {
  Near near(5e-4, 1e-4);
  const TouchingModel touching(*near.model, near.contact, near.state, 0.01);
  Near same(5e-4, 1e-4);
  same.contact.options.mu = 0;
  const TouchingModel smooth(*same.model, same.contact, same.state, 0.01);
  State s = near.state;
  s.x += 2e-5 * random_vector(s.x.size(), 3);
  for (const TouchingModel* model : {&touching, &smooth}) model->free_share(near.state.x, s.x - near.state.x);
  const auto friction = [&](const VectorX& x) { return VectorX(near.force(touching, x) - same.force(smooth, x)); };
  const SparseMatrix difference =
      touching.tangent(s, TangentKind::exact).dfdx - smooth.tangent(s, TangentKind::exact).dfdx;
  EXPECT_LE(relative_error(MatrixX(difference), central_differences(friction, s.x, 1e-9)), 1e-4);
}

TEST(TouchingModel, LocalModelsFrictionIsASpringOrADamperWithTheStepsForce) {
  constexpr double kStep = 0.01;
  Near near(5e-4, 1e-4);
  const TouchingModel touching(*near.model, near.contact, near.state, kStep);
  Near same(5e-4, 1e-4);
  same.contact.options.mu = 0;
  const TouchingModel smooth(*same.model, same.contact, same.state, kStep);
  // All slip by a third or three times the slip at which friction is full.
  const int half = near.model->mesh().num_nodes() / 2;
  for (const double slip : {0.3, 3.0}) {
    State s = near.state;
    VectorX motion = VectorX::Zero(s.x.size());
    for (int i = half; i < 2 * half; ++i)
      node(motion, i) = slip * near.contact.options.creep * kStep * Vec3(0.6, 0.8, 0);
    s.x += motion;
    for (const TouchingModel* model : {&touching, &smooth}) model->find_near(s.x);
    const VectorX friction = near.force(touching, s.x) - same.force(smooth, s.x);
    ASSERT_GT(friction.norm(), 0);
    for (const TangentKind kind : {TangentKind::symmetric, TangentKind::definite}) {
      const Tangent with = touching.tangent(s, kind), without = smooth.tangent(s, kind);
      const VectorX springs = (with.dfdx - without.dfdx) * motion,
                    dampers = (with.dfdv - without.dfdv) * motion / kStep;
      EXPECT_LE(relative_error(slip < 1 ? springs : dampers, friction), 1e-9) << slip;
      EXPECT_LE((slip < 1 ? dampers : springs).norm(), 0.3 * friction.norm()) << slip;  // pairs that face another way
      EXPECT_LE((with.dfdv - without.dfdv).toDense().selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff(), 1e-9);
    }
  }
}

TEST(TouchingEuler, KeepsMomentumInFlight) {
  PressedBodies scene = flying_blocks(4);
  SelfContact contact(*scene.model, {.mu = 0.3});
  TouchingEuler integrator(contact, {.convergence = 1e-12});
  const auto momentum = [&] {
    const VectorX p = scene.model->mass() * scene.state.v;
    Eigen::Matrix<double, 6, 1> out = Eigen::Matrix<double, 6, 1>::Zero();
    for (int i = 0; i < scene.model->mesh().num_nodes(); ++i) {
      out.head<3>() += node(p, i);
      out.tail<3>() += Vec3(node(scene.state.x, i)).cross(Vec3(node(p, i)));
    }
    return out;
  };
  const double energy = 0.5 * scene.state.v.dot(scene.model->mass() * scene.state.v);
  const auto before = momentum();
  int contacts = 0;
  for (int i = 0; i < 40; ++i) {
    scene.step(integrator);
    contacts = std::max(contacts, integrator.report().contacts);
  }
  EXPECT_GT(contacts, 0);
  // Newton's method may end a step with its last motion cut short once that is below 1e-9 of the size of the bodies.
  const double left_over = 40 * 1e-9 * bounds(scene.model->mesh()).size().norm() / scene.dt;
  EXPECT_LE((momentum() - before).head<3>().norm(), left_over * scene.model->mass().diagonal().sum() / 3);
  EXPECT_LT(0.5 * scene.state.v.dot(scene.model->mass() * scene.state.v), energy);
}

#if KT_WITH_CGAL
TEST(TouchingEuler, KeepsBodiesFromPassingThroughOneAnother) {
  const std::function<PressedBodies()> scenes[] = {[] { return sheared_blocks(4); }, [] { return folded_sheet(12); },
                                                   [] { return stacked_blocks(4); }};
  for (const auto& make : scenes) {
    PressedBodies scene = make();
    scene.dt = 0.04;  // as long as a global step gets
    SelfContact contact(*scene.model, {.mu = 0.3});
    TouchingEuler integrator(contact, {.convergence = 1e-6});
    Mesh now = scene.model->mesh();
    int contacts = 0;
    for (int i = 0; i < 110; ++i) {
      scene.step(integrator);
      contacts = std::max(contacts, integrator.report().contacts);
      now.x = scene.state.x;
      bool complete = false;
      ASSERT_TRUE(find_self_intersections(now, 1, complete).empty()) << scene.name << ", step " << i;
    }
    EXPECT_GT(contacts, 20) << scene.name;
  }
}
#endif

}  // namespace
}  // namespace kt
