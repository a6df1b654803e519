// The paper's operators, built literally as dense 3m x 3m matrices, against the closed forms that the engine uses.
#include "haptics/contact/projection.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "haptics/contact/contact_solver.hpp"

namespace kt {
namespace {

constexpr double kRoundoff = 1e-12;  // sums of at most 21 terms of order one, and one 21 x 21 inverse
constexpr int kNodes = 7;            // the contact triangle is 0, 1, 2

class Random {
 public:
  double uniform(double low, double high) { return std::uniform_real_distribution(low, high)(engine_); }
  VectorX vector(int size) {
    return VectorX::NullaryExpr(size, [&] { return uniform(-1, 1); });
  }
  Vec3 unit() {
    Vec3 v = vector(3);
    while (v.norm() < 0.1) v = vector(3);
    return v.normalized();
  }
  Vec3 bary() {
    const Vec3 w(uniform(0.01, 1), uniform(0.01, 1), uniform(0.01, 1));
    return w / w.sum();
  }

 private:
  std::mt19937 engine_{7};
};

/// Fills the rows from `known` on by Gram-Schmidt over the unit vectors; the given rows stay as they are.
void complete_rows(MatrixX& m, int known) {
  for (int candidate = 0; known < m.rows() && candidate < m.cols(); ++candidate) {
    Eigen::RowVectorXd row = Eigen::RowVectorXd::Unit(m.cols(), candidate);
    for (int pass = 0; pass < 2; ++pass)
      for (int i = 0; i < known; ++i) row -= row.dot(m.row(i)) / m.row(i).squaredNorm() * m.row(i);
    if (row.norm() > 1e-3) m.row(known++) = row.normalized();
  }
}

struct PaperOperators {
  MatrixX J, P, P_force, Q, Q_force;  // P_force, Q_force: with a tilde in the paper
};

PaperOperators build(const Vec3& bary, const Vec3& normal) {
  const int size = 3 * kNodes;
  MatrixX T = MatrixX::Identity(size, size);  // eqs. (7)-(8)
  MatrixX T11 = MatrixX::Zero(9, 9);
  for (int c = 0; c < 3; ++c) T11.block<3, 3>(0, 3 * c) = bary[c] * Mat3::Identity();
  complete_rows(T11, 3);
  T.topLeftCorner<9, 9>() = T11;

  MatrixX U0 = MatrixX::Zero(3, 3);  // eqs. (16)-(18)
  U0.row(0) = normal.transpose();
  complete_rows(U0, 1);
  MatrixX U = T;
  U.topRows<3>() = U0 * T.topRows<3>();

  const auto keep = [&](int first, int count) {
    MatrixX d = MatrixX::Zero(size, size);
    d.diagonal().segment(first, count).setOnes();
    return d;
  };
  PaperOperators out;
  out.J = T.topRows<3>();
  out.P = T.inverse() * keep(3, size - 3) * T;                         // eq. (10)
  out.P_force = T.transpose() * keep(0, 3) * T.transpose().inverse();  // eq. (13)
  out.Q = U.inverse() * keep(1, size - 1) * U;                         // eq. (19)
  out.Q_force = U.transpose() * keep(0, 1) * U.transpose().inverse();  // eq. (21)
  return out;
}

Vec3 sum_of_triangle(const VectorX& f) { return f.segment<3>(0) + f.segment<3>(3) + f.segment<3>(6); }

/// One contact as the geometric laws see it, and what the paper's matrices say about it.
struct Example {
  Vec3 bary, normal;
  double s = 0;
  PaperOperators paper;
  VectorX mass_inverse, force, velocity;  // velocity: after the forces
  ContactProblem problem;
};

Example make_example(Random& random) {
  Example e;
  e.bary = random.bary();
  e.normal = random.unit();
  e.s = weight_square(e.bary, {true, true, true});
  e.paper = build(e.bary, e.normal);
  e.mass_inverse = (random.vector(3 * kNodes).array() * 0.4 + 1).matrix();
  e.force = random.vector(3 * kNodes);
  const double h = 1e-3;
  e.velocity = random.vector(3 * kNodes) + h * e.mass_inverse.cwiseProduct(e.force);
  if (e.normal.dot(Vec3(e.paper.J * e.force)) < 0) e.normal = -e.normal;  // the body pushes
  e.paper = build(e.bary, e.normal);
  e.problem.count = 1;
  e.problem.h = h;
  e.problem.normal[0] = e.normal;
  e.problem.velocity = e.paper.J * e.velocity;
  e.problem.W = e.s * Mat3::Identity();  // the identity metric: J J^T
  e.problem.force = e.paper.J * e.force / e.s;
  e.problem.inertia = e.paper.J * e.mass_inverse.asDiagonal() * e.paper.J.transpose();
  return e;
}

ContactSolution solve(const std::string& law, double mu, const ContactProblem& problem) {
  ContactSolution out;
  make_contact_solver(law, {mu, mu})->solve(problem, out);
  return out;
}

/// What the engine does with a solution in the identity metric: v+ = v + J^T p + M^-1 J^T p_inertial.
VectorX apply(const Example& e, const ContactSolution& s) {
  return e.velocity + e.paper.J.transpose() * VectorX(s.impulse) +
         e.mass_inverse.asDiagonal() * (e.paper.J.transpose() * s.inertial_impulse);
}

TEST(PaperOperators, ClosedFormsEqualTheDenseMatrices) {
  Random random;
  for (int i = 0; i < 200; ++i) {
    const Vec3 bary = random.bary(), n = random.unit();
    const double s = weight_square(bary, {true, true, true});
    const PaperOperators m = build(bary, n);
    const MatrixX identity = MatrixX::Identity(3 * kNodes, 3 * kNodes);
    const MatrixX sticking = m.J.transpose() * m.J / s;
    const MatrixX sliding = m.J.transpose() * n * n.transpose() * m.J / s;
    EXPECT_LT((m.P - (identity - sticking)).cwiseAbs().maxCoeff(), kRoundoff);
    EXPECT_LT((m.P_force - sticking).cwiseAbs().maxCoeff(), kRoundoff);
    EXPECT_LT((m.Q - (identity - sliding)).cwiseAbs().maxCoeff(), kRoundoff);
    EXPECT_LT((m.Q_force - sliding).cwiseAbs().maxCoeff(), kRoundoff);
  }
}

TEST(PaperOperators, FunctionsOfTheirNamesActAsTheDenseMatrices) {
  Random random;
  for (int i = 0; i < 200; ++i) {
    const Example e = make_example(random);
    const Vec3 v = e.paper.J * e.velocity, force = e.problem.force;
    const auto after = [&](const Vec3& impulse) { return VectorX(e.velocity + e.paper.J.transpose() * impulse); };
    EXPECT_LT((after(paper::P(e.problem.W, v)) - e.paper.P * e.velocity).norm(), kRoundoff);
    EXPECT_LT((after(paper::Q(e.problem.W, e.normal, v)) - e.paper.Q * e.velocity).norm(), kRoundoff);
    EXPECT_LT((paper::P_tilde(force) - sum_of_triangle(e.paper.P_force * e.force)).norm(), kRoundoff);
    EXPECT_LT((paper::Q_tilde(force, e.normal) - sum_of_triangle(e.paper.Q_force * e.force)).norm(), kRoundoff);
  }
}

TEST(PaperStick, IsThePapersProjectionAndForce) {
  Random random;
  for (int i = 0; i < 200; ++i) {
    const Example e = make_example(random);
    const ContactSolution s = solve("paper_stick", 1, e.problem);
    ASSERT_EQ(s.mode[0], ContactMode::stick);
    EXPECT_LT((apply(e, s) - e.paper.P * e.velocity).norm(), kRoundoff);                          // eq. (12)
    EXPECT_LT((s.force_on_tool - sum_of_triangle(e.paper.P_force * e.force)).norm(), kRoundoff);  // eq. (14)
  }
}

TEST(PaperSlide, IsThePapersProjectionAndForce) {
  Random random;
  for (int i = 0; i < 200; ++i) {
    const Example e = make_example(random);
    const ContactSolution s = solve("paper_slide", 0, e.problem);
    ASSERT_EQ(s.mode[0], ContactMode::slide);
    EXPECT_LT((apply(e, s) - e.paper.Q * e.velocity).norm(), kRoundoff);                          // eq. (20)
    EXPECT_LT((s.force_on_tool - sum_of_triangle(e.paper.Q_force * e.force)).norm(), kRoundoff);  // eq. (22)
    EXPECT_LT(split(s.force_on_tool, e.normal).tangential.norm(), kRoundoff);
  }
}

TEST(PaperStickSlip, SlidesAsInEquations23To28WhenTheConeIsLeft) {
  Random random;
  int slid = 0;
  for (int i = 0; i < 400; ++i) {
    const Example e = make_example(random);
    const double mu = random.uniform(0, 1.5);
    const ContactSolution s = solve("paper_stick_slip", mu, e.problem);
    const VectorX f_tilde = e.paper.P_force * e.force;  // eq. (23)
    const Vec3 f_instr = sum_of_triangle(f_tilde);      // eq. (27)
    const Vec3 f_n = e.normal.dot(f_instr) * e.normal, f_t = f_instr - f_n;
    if (f_t.norm() <= mu * f_n.norm()) {
      EXPECT_EQ(s.mode[0], ContactMode::stick);
      continue;
    }
    ++slid;
    ASSERT_EQ(s.mode[0], ContactMode::frictional_slide);
    EXPECT_LT((s.force_on_tool - (f_n + mu * f_n.norm() / f_t.norm() * f_t)).norm(), kRoundoff);  // eq. (28)

    VectorX left_over = e.force;  // eqs. (24)-(25): node by node
    for (int node = 0; node < 3; ++node) {
      const Vec3 f = f_tilde.segment<3>(3 * node);
      const Vec3 n = e.normal.dot(f) * e.normal, t = f - n;
      left_over.segment<3>(3 * node) -= n + mu * n.norm() / t.norm() * t;
    }
    const double h = e.problem.h;
    const VectorX before = e.velocity - h * e.mass_inverse.cwiseProduct(e.force);
    const VectorX expected = e.paper.Q * (before + h * e.mass_inverse.cwiseProduct(left_over));  // eq. (26)
    EXPECT_LT((apply(e, s) - expected).norm(), kRoundoff);
  }
  EXPECT_GT(slid, 50);
}

TEST(PaperLaws, LetGoWhenTheSurfaceWouldPull) {
  Random random;
  Example e = make_example(random);
  e.problem.force = -e.problem.force;
  for (const char* law : {"paper_slide", "paper_stick", "paper_stick_slip"}) {
    const ContactSolution s = solve(law, 1, e.problem);
    EXPECT_EQ(s.mode[0], ContactMode::free);
    EXPECT_TRUE(s.impulse.isZero(0) && s.inertial_impulse.isZero(0) && s.force_on_tool.isZero(0));
  }
}

TEST(WeightSquare, CountsOnlyVerticesThatMove) {
  const Vec3 bary(0.5, 0.3, 0.2);
  EXPECT_DOUBLE_EQ(weight_square(bary, {true, true, true}), 0.38);
  EXPECT_DOUBLE_EQ(weight_square(bary, {true, false, true}), 0.29);
  EXPECT_EQ(weight_square(bary, {false, false, false}), 0);
}

TEST(FrictionCone, ClippedForceLiesOnItAndStaysThere) {
  Random random;
  for (int i = 0; i < 100000; ++i) {
    const Vec3 n = random.unit();
    const double mu = random.uniform(0, 3);
    const Vec3 force = std::pow(10.0, random.uniform(-12, 6)) * Vec3(random.vector(3));
    const Vec3 once = clip_to_cone(force, n, mu), twice = clip_to_cone(once, n, mu);
    const double scale = std::abs(n.dot(force));
    // Taking the parts of the result again costs one rounding of the whole force.
    const double rounding = 4e-16 * (1 + mu) * scale;
    const auto [f_n, f_t] = split(once, n);
    ASSERT_NEAR(f_n, n.dot(force), 1e-12 * scale);
    ASSERT_LE(f_t.norm(), mu * std::abs(f_n) * (1 + 1e-12) + rounding);
    ASSERT_LT((twice - once).norm(), 1e-12 * (1 + mu) * scale);
    ASSERT_GE(f_t.dot(split(force, n).tangential), -rounding * force.norm());
  }
}

TEST(FrictionCone, PurelyNormalForceStays) {
  EXPECT_EQ(clip_to_cone({0, 0, 2}, Vec3::UnitZ(), 0.5), Vec3(0, 0, 2));
  EXPECT_EQ(clip_to_cone(Vec3::Zero(), Vec3::UnitZ(), 0.5), Vec3::Zero());
}

}  // namespace
}  // namespace kt
