// Energy in a local model, and what a swap of two of them gives.
#include <gtest/gtest.h>

#include "haptics/halves/swap_energy.hpp"
#include "haptics/session/session.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

SparseMatrix sparse(const MatrixX& m) { return m.sparseView(0, 0); }

double energy(const MatrixX& stiffness, const VectorX& f0, const VectorX& q) {
  LocalModel model;
  model.stiffness = sparse(stiffness);
  model.f0 = f0;
  return stored_energy(model, std::span(&q, 1))[0];
}

MatrixX some_stiffness() {
  MatrixX k(3, 3);
  k << 300, -80, 20, -80, 250, -60, 20, -60, 400;
  return k;
}

TEST(StoredEnergy, IsTheWorkOfItsForceOnTheWayToRest) {
  const Vec3 f0(1, -2, 0.5), q(0.01, 0.003, -0.02);
  for (const bool coupled : {false, true}) {
    MatrixX k = some_stiffness();
    if (!coupled) k = MatrixX(k.diagonal().asDiagonal());
    const VectorX rest = k.fullPivLu().solve(VectorX(f0));
    // The force f0 - K q along a straight way, piece by piece at the middle: exact for a linear force.
    double work = 0;
    constexpr int kPieces = 10;
    for (int i = 0; i < kPieces; ++i) {
      const VectorX at = q + (i + 0.5) / kPieces * (rest - q);
      work += (f0 - k * at).dot(rest - q) / kPieces;
    }
    EXPECT_NEAR(energy(k, f0, q), work, 1e-12 * work);
    EXPECT_NEAR(energy(k, f0, rest), 0, 1e-15);
  }
}

TEST(StoredEnergy, IsTheSameInTwoModelsOfOneLinearBody) {
  // Linearized elsewhere, in other coordinates: x = at + B y.
  const MatrixX k = some_stiffness();
  const Vec3 f0(1, -2, 0.5), at(0.004, -0.001, 0.002), y(0.3, -0.2, 0.1);
  MatrixX b(3, 3);
  b << 0.02, 0.001, 0, 0, 0.05, -0.01, 0.003, 0, 0.04;
  const VectorX x = at + b * y;
  const double here = energy(k, f0, x), there = energy(b.transpose() * k * b, b.transpose() * (f0 - k * at), y);
  EXPECT_NEAR(there, here, 1e-12 * here);
  // A body that is a tenth stiffer at the next refresh, pressed as far: a tenth more is in it than was put in.
  const VectorX rest = k.fullPivLu().solve(VectorX(f0));
  EXPECT_NEAR(energy(1.1 * k, 1.1 * f0, x) - here, 0.1 * here, 1e-12 * here);
  EXPECT_EQ(rest.size(), 3);
}

TEST(StoredEnergy, IsNoneOfAModelThatIsNotDefinite) {
  MatrixX k = some_stiffness();
  k(0, 1) = k(1, 0) = 400;
  EXPECT_TRUE(std::isnan(energy(k, Vec3(1, 0, 0), Vec3(0, 0, 1))));
  EXPECT_TRUE(std::isnan(energy(-some_stiffness(), Vec3(1, 0, 0), Vec3(0, 0, 1))));
  EXPECT_TRUE(std::isnan(energy(some_stiffness(), Vec3(1, 0, 0), VectorX::Zero(2))));
}

TEST(RefreshEnergy, OfARunIsBookedForEachSwapAndSmallBesideItsWork) {
  const SessionResult run = Session(small_scene()).run();
  const auto adopted = std::ranges::count_if(run.refreshes, [](const RefreshEvent& r) { return r.adopted_tick >= 0; });
  ASSERT_GT(adopted, 4);
  // The first model comes out of nothing, the last one's end is not known.
  EXPECT_EQ(run.refresh.energy.swaps, adopted - 2);
  double work = 0;
  Vec3 before = run.tools[0].frames[0].pose.x;
  for (const LocalFrame& f : run.tools[0].frames) {
    work += std::abs(f.force.dot(f.pose.x - before));
    before = f.pose.x;
  }
  EXPECT_GT(work, 0);
  EXPECT_NE(run.refresh.energy.sum, 0);
  EXPECT_LE(std::abs(run.refresh.energy.largest), work);
  EXPECT_LE(std::abs(run.refresh.energy.sum), work);
}

}  // namespace
}  // namespace kt
