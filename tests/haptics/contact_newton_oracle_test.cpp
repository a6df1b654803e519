// Direct solutions of a few contacts: against every choice of who pushes, and near the answer of sweeps.
#include "haptics/contact/contact_newton.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

#include "haptics/contact/contact_sweeps.hpp"

namespace kt {
namespace {

struct Problem {
  MatrixX W;
  VectorX velocity;
  std::vector<Vec3> normal;
  std::vector<Friction> friction;
  ContactSystem system() const { return {normal, friction, {}, velocity, W}; }
};

class Problems {
 public:
  /// @param freedoms  of the body
  Problem next(int c, int freedoms, double mu) {
    const MatrixX J = MatrixX::NullaryExpr(3 * c, freedoms, [&] { return normal(); });
    Problem out;
    out.W = J * J.transpose();
    out.velocity = VectorX::NullaryExpr(3 * c, [&] { return normal(); });
    for (int i = 0; i < c; ++i) out.normal.push_back(Vec3(0.3 * normal(), 0.3 * normal(), 1).normalized());
    out.friction.assign(static_cast<std::size_t>(c), {mu, mu});
    return out;
  }
  double normal() { return std::normal_distribution()(engine_); }

 private:
  std::mt19937_64 engine_{5};
};

/// Without friction: along the normals, of all 2^c choices of who pushes the one that nobody pulls in and nobody
/// overlaps in.
VectorX by_enumeration(const Problem& p) {
  const auto c = static_cast<int>(p.normal.size());
  MatrixX along = MatrixX::Zero(3 * c, c);
  for (int i = 0; i < c; ++i) along.block<3, 1>(3 * i, i) = -p.normal[i];
  const MatrixX A = along.transpose() * p.W * along;
  const VectorX b = along.transpose() * p.velocity;
  for (unsigned choice = 0; choice < 1u << c; ++choice) {
    std::vector<int> pushing;
    for (int i = 0; i < c; ++i)
      if (choice >> i & 1) pushing.push_back(i);
    VectorX x = VectorX::Zero(c);
    if (!pushing.empty()) x(pushing) = MatrixX(A(pushing, pushing)).ldlt().solve(VectorX(-b(pushing))).eval();
    const VectorX u = A * x + b;
    bool is_answer = x.minCoeff() >= 0;
    for (int i = 0; i < c; ++i) is_answer = is_answer && ((choice >> i & 1) || u[i] >= 0);
    if (is_answer) return along * x;
  }
  ADD_FAILURE() << "positive definite: there is one";
  return VectorX::Zero(3 * c);
}

TEST(ContactNewton, PivotsToTheOneChoiceOfWhoPushes) {
  Problems problems;
  int pushing = 0, total = 0;
  for (int k = 0; k < 300; ++k) {
    const int c = 2 + k % 7;
    const Problem p = problems.next(c, 3 * c + 2, 0);
    const VectorX expected = by_enumeration(p);
    std::vector<ContactMode> mode(p.normal.size());
    VectorX impulse = VectorX::Zero(3 * c);
    for (int i = 0; i < c; ++i) {  // whoever was thought to push
      mode[i] = (k >> i) & 1 ? ContactMode::slide : ContactMode::free;
      if (mode[i] == ContactMode::slide) impulse.segment<3>(3 * i) = -p.normal[i];
    }
    ContactNewton newton;
    ContactWork work(1'000'000'000);
    ASSERT_TRUE(newton.pivot(p.system(), 3 * static_cast<int>(p.normal.size()),
                             std::vector<double>(p.normal.size(), 0.0), mode, impulse, work))
        << "problem " << k;
    EXPECT_LT((impulse - expected).norm(), 1e-7 * std::max(expected.norm(), 1e-3)) << "problem " << k;
    for (int i = 0; i < c; ++i) pushing += !expected.segment<3>(3 * i).isZero(0);
    total += c;
  }
  EXPECT_GT(pushing, total / 4);
  EXPECT_LT(pushing, 3 * total / 4);
}

TEST(ContactNewton, ConvergesFastNearASolution) {
  Problems problems;
  int slips = 0, sticks = 0;
  for (int k = 0; k < 200; ++k) {
    const int c = 2 + k % 10;
    const double mu = 0.2 + 0.1 * (k % 8);
    const Problem p = problems.next(c, 3 * c + 6, mu);
    VectorX solution = VectorX::Zero(3 * c);
    std::vector<ContactMode> mode(p.normal.size());
    ASSERT_LE(ContactSweeps(c).solve(p.system(), {.sweeps = 1000, .residual = 1e-12}, solution, mode).residual, 1e-12);
    slips += static_cast<int>(std::ranges::count(mode, ContactMode::frictional_slide));
    sticks += static_cast<int>(std::ranges::count(mode, ContactMode::stick));
    const std::vector<double> cone(p.normal.size(), mu);
    VectorX impulse = solution;
    for (double& x : impulse) x += 1e-4 * solution.norm() * problems.normal();
    ContactNewton newton;
    ContactWork work(1'000'000'000);
    for (int step = 0; step < 5; ++step) ASSERT_TRUE(newton.step(p.system(), cone, impulse, work));
    EXPECT_LE((impulse - solution).norm(), 1e-8 * solution.norm()) << "problem " << k;
  }
  EXPECT_GT(std::min(slips, sticks), 50);
}

}  // namespace
}  // namespace kt
