// Several contacts with Coulomb friction over random bodies.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "haptics/contact/contact_solver.hpp"
#include "haptics/contact/one_contact.hpp"
#include "tests/support/haptics_coulomb.hpp"

namespace kt {
namespace {

struct Problem {
  ContactProblem contacts;
  std::vector<Vec3> normal;
};

class Problems {
 public:
  /// c contacts of a tool with a random body: normals within 50 degrees of each other, W = J A^-1 J^T with A of a
  /// condition as in a mesh, bodies moving mostly into the tool.
  Problem next(int c) {
    const int dofs = 3 * c + 6;
    const MatrixX J = MatrixX::NullaryExpr(3 * c, dofs, [&] { return normal(); });
    const VectorX a = VectorX::NullaryExpr(dofs, [&] { return std::pow(10.0, uniform(-1.5, 0)); });
    Problem out;
    out.contacts.count = c;
    out.contacts.h = 1e-3;
    out.contacts.W = J * a.asDiagonal() * J.transpose();
    out.contacts.velocity = VectorX::NullaryExpr(3 * c, [&] { return normal(); });
    for (int i = 0; i < c; ++i) {
      out.normal.push_back((Vec3::UnitZ() + 0.5 * Vec3(uniform(-1, 1), uniform(-1, 1), 0)).normalized());
      out.contacts.normal[i] = out.normal[i];
      out.contacts.velocity.segment<3>(3 * i) += out.normal[i];
    }
    return out;
  }
  double uniform(double low, double high) { return std::uniform_real_distribution(low, high)(engine_); }

 private:
  double normal() { return std::normal_distribution()(engine_); }
  std::mt19937 engine_{5};
};

constexpr int kSweepLimit = 100;
constexpr double kStopped = 1e-6;  // where the solver stops: its residual

TEST(Coulomb, ConvergedSolutionsMeetTheConditions) {
  Problems problems;
  int converged = 0, total = 0;
  for (int i = 0; i < 1000; ++i) {
    const int c = 2 + i % (kMaxContacts - 1);
    const double mu = i % 7 == 0 ? 0 : problems.uniform(0, 0.8);
    const Problem p = problems.next(c);
    ContactSolution s;
    make_contact_solver("coulomb", {mu, mu})->solve(p.contacts, s);
    ASSERT_LE(s.iterations, kSweepLimit);
    ASSERT_TRUE(s.impulse.allFinite());
    Vec3 total_impulse = Vec3::Zero();
    for (int k = 0; k < c; ++k) {  // each contact is exact in itself, converged or not
      const Vec3 own = s.impulse.segment<3>(3 * k), m = -p.normal[k];
      total_impulse += own;
      ASSERT_GE(m.dot(own), 0);
      ASSERT_LE((own - m.dot(own) * m).norm(), mu * m.dot(own) + 1e-14 * own.norm());
      ASSERT_EQ(s.mode[k] == ContactMode::free, own.isZero(0));
    }
    ASSERT_LT((s.force_on_tool + total_impulse / p.contacts.h).norm(),
              1e-12 * total_impulse.norm() / p.contacts.h + 1e-300);
    ++total;
    if (s.residual > kStopped) continue;
    ++converged;
    // The same conditions with another step length and norm: at most as many times as there are contacts.
    ASSERT_LT(coulomb_residual(p.contacts.W, p.contacts.velocity, p.normal, mu, s.impulse), kMaxContacts * kStopped)
        << "problem " << i << ", " << c << " contacts, mu " << mu;
  }
  RecordProperty("converged", converged);
  EXPECT_EQ(converged, total);
}

TEST(Coulomb, OneContactIsSolvedExactly) {
  Problems problems;
  for (int i = 0; i < 1000; ++i) {
    const Friction friction{0.7, 0.4};
    const Problem p = problems.next(1);
    ContactSolution s;
    make_contact_solver("coulomb", friction)->solve(p.contacts, s);
    const auto expected = OneContact(Mat3(p.contacts.W), p.normal[0]).solve(Vec3(p.contacts.velocity), friction);
    EXPECT_EQ(Vec3(s.impulse), expected.impulse);
    EXPECT_EQ(s.mode[0], expected.mode);
    EXPECT_EQ(s.iterations, 1);
  }
}

TEST(Coulomb, StartingFromTheSolutionStaysThere) {
  Problems problems;
  const auto solver = make_contact_solver("coulomb", {0.5, 0.5});
  for (int i = 0; i < 200; ++i) {
    const Problem p = problems.next(5);
    ContactSolution cold;
    solver->solve(p.contacts, cold);
    if (cold.residual > kStopped) continue;
    ContactSolution warm = cold;
    solver->solve(p.contacts, warm);
    EXPECT_LE(warm.iterations, 2);
    EXPECT_LT((warm.impulse - cold.impulse).norm(), 10 * kStopped * cold.impulse.norm());
  }
}

}  // namespace
}  // namespace kt
