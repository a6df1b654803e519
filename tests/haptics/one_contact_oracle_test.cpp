// One contact with exact Coulomb friction, against its own conditions and against a solver of another kind.
#include "haptics/contact/one_contact.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "tests/support/haptics_coulomb.hpp"

namespace kt {
namespace {

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

 private:
  double uniform(double low, double high) { return std::uniform_real_distribution(low, high)(engine_); }
  double normal() { return std::normal_distribution()(engine_); }
  std::mt19937 engine_{11};
};

/// Size of the numbers that u = W p + b is made of: its rounding is a few 1e-16 of it.
double velocity_scale(const Case& c, const Vec3& p) { return c.W.norm() * p.norm() + c.b.norm(); }

constexpr double kRoundoff = 1e-14;

TEST(OneContact, MeetsSignoriniAndCoulomb) {
  Cases cases;
  int sticking = 0, slipping = 0, jammed = 0, free = 0;
  for (int i = 0; i < 100000; ++i) {
    const Case c = cases.next(6, i % 10 == 0 ? 20.0 : 1.5);
    const auto [p, mode] = solve_one_contact(c.W, c.b, c.normal, c.friction);
    const Vec3 m = -c.normal, u = c.W * p + c.b;
    const double p_m = m.dot(p), u_m = m.dot(u), tiny = kRoundoff * velocity_scale(c, p);
    const Vec3 p_t = p - p_m * m, u_t = u - u_m * m;
    SCOPED_TRACE(testing::Message() << "case " << i << ", mu " << c.friction.mu_kinetic);
    ASSERT_TRUE(p.allFinite());
    ASSERT_GE(p_m, 0);
    if (mode == ContactMode::free) {
      ++free;
      ASSERT_TRUE(p.isZero(0));
      ASSERT_GE(u_m, 0);
      continue;
    }
    ASSERT_GT(p_m, 0);
    if (mode == ContactMode::stick) {
      ++sticking;
      const double condition = c.W.norm() * c.W.inverse().norm();  // p = -W^-1 b knows b to this
      ASSERT_LE(u.norm(), condition * tiny);
      ASSERT_LE(p_t.norm(), c.friction.mu_static * p_m * (1 + 1e-9));
      continue;
    }
    if (p_m * m.dot(c.W * m) > -999.9 * m.dot(c.b)) {  // cut off on purpose
      ++jammed;
      continue;
    }
    ++slipping;
    ASSERT_LE(std::abs(u_m), 100 * tiny);
    ASSERT_EQ(mode, c.friction.mu_static == 0 ? ContactMode::slide : ContactMode::frictional_slide);
    ASSERT_NEAR(p_t.norm(), c.friction.mu_kinetic * p_m, kRoundoff * p.norm());
    if (c.friction.mu_kinetic == 0) continue;
    // Opposite: p_t x u_t = 0 and p_t . u_t <= 0, in units of |p_t|.
    const Vec3 d = p_t.normalized();
    ASSERT_LE(std::abs(m.cross(d).dot(u_t)), 100 * tiny);
    ASSERT_LE(d.dot(u_t), 100 * tiny);
  }
  EXPECT_GT(sticking, 5000);
  EXPECT_GT(slipping, 5000);
  EXPECT_GT(free, 5000);
  EXPECT_LT(jammed, 1000);
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

TEST(OneContact, GuessChangesTheSpeedAndNotTheConditions) {
  Cases cases;
  for (int i = 0; i < 10000; ++i) {
    const Case c = cases.next(2, 0.5);
    const Vec3 plain = solve_one_contact(c.W, c.b, c.normal, c.friction).impulse;
    const Vec3 near = solve_one_contact(c.W, c.b, c.normal, c.friction, plain).impulse;
    const Vec3 opposite = solve_one_contact(c.W, c.b, c.normal, c.friction, -plain).impulse;
    ASSERT_LT((near - plain).norm(), 1e-10 * plain.norm() + 1e-300);
    ASSERT_LT(coulomb_residual(c.W, c.b, {c.normal}, c.friction.mu_kinetic, opposite),
              c.friction.mu_static > c.friction.mu_kinetic ? 10 : 1e-9);
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
