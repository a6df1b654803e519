// One contact with exact Coulomb friction, against its own conditions and against a solver of another kind.
// KT_CONTACTS=100000 checks the conditions on more problems.
#include "haptics/contact/one_contact.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "haptics/contact/contact_sweeps.hpp"
#include "tests/support/environment.hpp"
#include "tests/support/haptics_coulomb.hpp"

namespace kt {
namespace {

OneContactSolution solve_one_contact(const Mat3& W, const Vec3& b, const Vec3& normal, const Friction& friction,
                                     bool sliding = false) {
  return OneContact(W, normal).solve(b, friction, sliding);
}

struct Case {
  Mat3 W;
  Vec3 b, normal;
  Friction friction;
};

class Cases {
 public:
  /// Condition of W up to 10^decades, its size anywhere; mu often 0, sometimes large; mu_s above mu_k in half of them.
  Case next(double decades, double mu_max) {
    const Mat3 R = Eigen::Quaterniond(normal(), normal(), normal(), normal()).normalized().toRotationMatrix();
    Vec3 scale;
    for (double& s : scale) s = std::pow(10.0, uniform(-decades, 0));
    Case c;
    const Mat3 W = std::pow(10.0, uniform(-3, 3)) * R * scale.asDiagonal() * R.transpose();
    c.W = 0.5 * (W + W.transpose());
    c.b = Vec3(normal(), normal(), normal());
    c.normal = Vec3(normal(), normal(), normal()).normalized();
    if (uniform(0, 1) < 0.7) c.b -= 2 * std::max(0.0, -c.normal.dot(c.b)) * -c.normal;  // mostly: moving into the tool
    const double kind = uniform(0, 1);
    c.friction.mu_kinetic = kind < 0.1 ? 0 : uniform(0, mu_max);
    c.friction.mu_static = c.friction.mu_kinetic * (uniform(0, 1) < 0.5 ? 1 : uniform(1, 2));
    return c;
  }

  double uniform(double low, double high) { return std::uniform_real_distribution(low, high)(engine_); }

 private:
  double normal() { return std::normal_distribution()(engine_); }
  std::mt19937 engine_{11};
};

/// Size of the numbers that u = W p + b is made of: its rounding is a few 1e-16 of it.
double velocity_scale(const Case& c, const Vec3& p) { return c.W.norm() * p.norm() + c.b.norm(); }

/// How far the law's conditions are from met, as a share of the velocities (impulses) they are made of.
struct Errors {
  double pull, overlap, complementarity, cone, opposite;
  double largest() const { return std::max({pull, overlap, complementarity, cone, opposite}); }
};

Errors errors_of(const Case& c, const OneContactSolution& s) {
  const Vec3 m = -c.normal, &p = s.impulse, u = c.W * p + c.b;
  const double v = velocity_scale(c, p), p_m = m.dot(p), u_m = m.dot(u);
  const Vec3 p_t = p - p_m * m, u_t = u - u_m * m;
  Errors e{};
  e.pull = p.isZero(0) ? 0 : std::max(0.0, -p_m / p.norm());
  e.overlap = std::max(0.0, -u_m / v);
  if (s.mode == ContactMode::free) {
    e.complementarity = p.isZero(0) ? 0 : 1;
    return e;
  }
  e.complementarity = std::abs(u_m) / v;
  const double mu = s.mode == ContactMode::stick ? c.friction.mu_static : c.friction.mu_kinetic;
  e.cone = std::max(0.0, p_t.norm() - mu * p_m) / p.norm();
  if (s.mode == ContactMode::stick) {
    e.opposite = u_t.norm() / v;
    return e;
  }
  e.cone = std::abs(p_t.norm() - mu * p_m) / p.norm();  // slipping: on its surface
  if (mu == 0) return e;
  const Vec3 d = p_t.normalized();
  e.opposite = std::max({std::abs(m.cross(d).dot(u_t)), d.dot(u_t), 0.0}) / v;
  return e;
}

TEST(OneContact, MeetsTheConditionsOfIllConditionedProblems) {
  const long count = number_from_environment("KT_CONTACTS", 30000);
  constexpr double kDemanded = 1e-9;
  Cases cases;
  int sticking = 0, slipping = 0, free = 0, near_jamming = 0;
  double worst = 0;
  for (long i = 0; i < count; ++i) {
    Case c = cases.next(8, i % 10 == 0 ? 20.0 : 3);
    if (i % 3 == 0) {  // where friction in the worst direction almost undoes the normal impulse, or just more than that
      const Vec3 m = -c.normal, coupling = c.W * m - m.dot(c.W * m) * m;
      if (!(coupling.norm() > 0)) continue;
      c.friction.mu_kinetic = m.dot(c.W * m) / coupling.norm() * (1 + (i % 2 ? 1 : -1) * std::pow(10.0, -1 - i % 7));
      c.friction.mu_static = c.friction.mu_kinetic * (i % 4 < 2 ? 1.0 : 1.2);
      ++near_jamming;
    }
    const OneContactSolution s = solve_one_contact(c.W, c.b, c.normal, c.friction);
    ASSERT_TRUE(s.impulse.allFinite()) << "case " << i;
    const Errors e = errors_of(c, s);
    worst = std::max(worst, e.largest());
    ASSERT_LE(e.largest(), kDemanded) << "case " << i << ": pull " << e.pull << ", overlap " << e.overlap
                                      << ", complementarity " << e.complementarity << ", cone " << e.cone
                                      << ", opposite " << e.opposite << ", mode " << name_of(s.mode) << ", mu "
                                      << c.friction.mu_kinetic;
    ++(s.mode == ContactMode::free ? free : s.mode == ContactMode::stick ? sticking : slipping);
  }
  RecordProperty("worst", testing::PrintToString(worst));
  EXPECT_GT(sticking, count / 50);
  EXPECT_GT(slipping, count / 10);
  EXPECT_GT(free, count / 50);
  EXPECT_GT(near_jamming, count / 4);
}

TEST(OneContact, WhatCannotMoveIsReported) {  // no impulse helps against the tool's way into it
  ContactSweeps solver(1);
  const std::vector<Vec3> normal{Vec3::UnitZ()};
  const std::vector<Friction> friction{{0.5, 0.5}};
  const VectorX velocity = Vec3(0, 0, 1);
  for (const Mat3& W : {Mat3(Mat3::Zero()), Mat3(Vec3(1, 1, 0).asDiagonal())}) {
    const MatrixX own = W;
    VectorX impulse = VectorX::Zero(3);
    ContactMode mode{};
    const SweepResult r = solver.solve({normal, friction, {}, velocity, own}, {}, impulse, {&mode, 1});
    EXPECT_TRUE(impulse.allFinite());
    EXPECT_GT(r.residual, 0.1);
  }
}

/// W diagonal, so that speed = |b_t| - W_t mu(speed) p_m with p_m = -b_m / W_m: one equation, by bisection.
TEST(OneContact, StribeckSlidesAtTheSpeedThatSuitsItsFriction) {
  Cases cases;
  int slid = 0, stuck = 0, several = 0;
  for (int i = 0; i < 3000; ++i) {
    const double W_m = cases.uniform(0.5, 2), W_t = cases.uniform(0.5, 2), b_m = -cases.uniform(0.1, 2);
    const double b_t = cases.uniform(0, 3), p_m = -b_m / W_m;
    const Friction friction{0.8, cases.uniform(0, 0.8), cases.uniform(0.02, 2)};
    const auto excess = [&](double speed) { return speed - b_t + W_t * friction.mu_at(speed) * p_m; };
    // Self-consistent speeds, from the fastest down.
    std::vector<double> speeds;
    constexpr int kSteps = 400;
    for (int k = kSteps; k > 0; --k) {
      double high = b_t * k / kSteps, low = b_t * (k - 1) / kSteps;
      if ((excess(high) > 0) == (excess(low) > 0)) continue;
      const bool rises = excess(high) > 0;
      for (int n = 0; n < 60; ++n) ((excess(0.5 * (low + high)) > 0) == rises ? high : low) = 0.5 * (low + high);
      speeds.push_back(high);
    }
    several += speeds.size() > 1;
    const Vec3 b(b_t, 0, -b_m);
    const Mat3 W = Vec3(W_t, W_t, W_m).asDiagonal();
    const bool can_stick = b_t <= W_t * friction.mu_static * p_m;
    for (const bool sliding : {false, true}) {
      const OneContactSolution s = solve_one_contact(W, b, Vec3::UnitZ(), friction, sliding);
      SCOPED_TRACE(testing::Message() << "case " << i << (sliding ? ", sliding" : ", at rest"));
      ASSERT_NEAR(-s.impulse.z(), p_m, 1e-12 * p_m);
      if (s.mode == ContactMode::stick) {
        ++stuck;
        ASSERT_TRUE(can_stick);
        if (sliding && friction.mu_kinetic > 0.05) {
          ASSERT_TRUE(speeds.empty() || speeds[0] < 1e-3 * b_t);
        }
        continue;
      }
      ++slid;
      const double speed = (W * s.impulse + b).x();
      ASSERT_NEAR(excess(speed), 0, 1e-9 * b_t);
      ASSERT_NEAR(s.impulse.x(), -friction.mu_at(speed) * p_m, 1e-12 * p_m);
      ASSERT_TRUE(sliding || !can_stick);
      if (sliding && friction.mu_kinetic > 0.05) {
        ASSERT_NEAR(speed, speeds[0], 1e-8 * b_t) << "the fastest of them";
      }
    }
  }
  EXPECT_GT(slid, 1000);
  EXPECT_GT(stuck, 500);
  EXPECT_GT(several, 50);
}

TEST(OneContact, WithoutStribeckFrictionFallsAtOnce) {
  const Mat3 W = Mat3::Identity();
  const Vec3 b(0.9, 0, 1);
  EXPECT_EQ(solve_one_contact(W, b, Vec3::UnitZ(), {0.8, 0.5}, false).mode, ContactMode::frictional_slide);
  EXPECT_NEAR(solve_one_contact(W, b, Vec3::UnitZ(), {0.8, 0.5, 1e-9}, false).impulse.x(), -0.5, 1e-12);
  EXPECT_NEAR(solve_one_contact(W, b, Vec3::UnitZ(), {0.8, 0.5}, false).impulse.x(), -0.5, 1e-12);
  EXPECT_EQ(solve_one_contact(W, Vec3(0.7, 0, 1), Vec3::UnitZ(), {0.8, 0.5}, false).mode, ContactMode::stick);
  EXPECT_EQ(solve_one_contact(W, Vec3(0.7, 0, 1), Vec3::UnitZ(), {0.8, 0.5}, true).mode, ContactMode::frictional_slide)
      << "sliding: the kinetic coefficient alone holds";
}

TEST(OneContact, AgreesWithProjectedIteration) {
  Cases cases;
  for (int i = 0; i < 2000; ++i) {
    Case c = cases.next(1.5, 0.4);  // here the solution is unique and the simple iteration converges
    c.friction.mu_static = c.friction.mu_kinetic;
    const Vec3 p = solve_one_contact(c.W, c.b, c.normal, c.friction).impulse;
    const Vec3 expected = project_iterate(c.W, c.b, {c.normal}, c.friction.mu_kinetic, 20000);
    ASSERT_LT((p - expected).norm(), 1e-7 * (c.b.norm() / c.W.norm() + expected.norm())) << "case " << i;
  }
}

TEST(OneContact, StartChangesTheSpeedAndNotTheConditions) {
  Cases cases;
  for (int i = 0; i < 10000; ++i) {
    const Case c = cases.next(2, 0.5);
    const OneContact contact(c.W, c.normal);
    const OneContactSolution plain = contact.solve(c.b, c.friction);
    const double size = plain.impulse.norm();
    for (const double start : {plain.lambda, 1e-3 * plain.lambda, 1e3 * plain.lambda + 1e-9, 1e30})
      ASSERT_LT((contact.solve(c.b, c.friction, false, start).impulse - plain.impulse).norm(), 1e-10 * size + 1e-300);
    if (plain.mode == ContactMode::frictional_slide && c.friction.mu_kinetic > 0) {
      ASSERT_NEAR(contact.slip_ratio(c.b, plain.impulse), plain.lambda, 1e-6 * (plain.lambda + c.W.norm()));
    }
  }
}

TEST(OneContact, HandValues) {
  const Vec3 up = Vec3::UnitZ(), b(3, 0, 4);  // the body moves up into the tool and sideways
  const Mat3 W = Mat3::Identity();
  EXPECT_EQ(solve_one_contact(W, b, up, {1, 1}).mode, ContactMode::stick);
  EXPECT_TRUE(solve_one_contact(W, b, up, {1, 1}).impulse.isApprox(Vec3(-3, 0, -4), 1e-14));
  EXPECT_EQ(solve_one_contact(W, b, up, {0.5, 0.5}).mode, ContactMode::frictional_slide);
  EXPECT_TRUE(solve_one_contact(W, b, up, {0.5, 0.5}).impulse.isApprox(Vec3(-2, 0, -4), 1e-14));
  EXPECT_TRUE(solve_one_contact(W, b, up, {0.8, 0.25}).impulse.isApprox(Vec3(-3, 0, -4), 1e-14)) << "held by mu_s";
  EXPECT_TRUE(solve_one_contact(W, b, up, {0.7, 0.25}).impulse.isApprox(Vec3(-1, 0, -4), 1e-14)) << "slips at mu_k";
  EXPECT_TRUE(solve_one_contact(W, b, up, {0, 0}).impulse.isApprox(Vec3(0, 0, -4), 1e-14));
  EXPECT_EQ(solve_one_contact(W, -b, up, {1, 1}).mode, ContactMode::free);
}

}  // namespace
}  // namespace kt
