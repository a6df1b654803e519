// The part of a tetrahedron on one side of a plane against many places in it.
#include "core/body/cut_tetrahedron.hpp"

#include <gtest/gtest.h>

#include "tests/support/random_sample.hpp"

namespace kt {
namespace {

/// By places that fill it evenly.
Eigen::Vector4d sampled(const Eigen::Vector4d& depth) {
  constexpr int kEdge = 60;
  Eigen::Vector4d inside = Eigen::Vector4d::Zero();
  int all = 0;
  for (int i = 0; i < kEdge; ++i)
    for (int j = 0; i + j < kEdge; ++j)
      for (int k = 0; i + j + k < kEdge; ++k) {
        const Eigen::Vector4d place = Eigen::Vector4d(i + 0.25, j + 0.25, k + 0.25, kEdge - i - j - k - 0.75) / kEdge;
        ++all;
        if (depth.dot(place) > 0) inside += place;
      }
  return inside / all;
}

TEST(CutTetrahedron, HoldsTheSideWhereTheFunctionIsPositive) {
  constexpr double kSpacing = 0.03;
  Sample sample{std::mt19937_64(11)};
  for (int i = 0; i < 60; ++i) {
    const Vec3 three = sample.cube();
    const Eigen::Vector4d depth(three[0], three[1], three[2], sample.cube()[0]);
    EXPECT_LT((cut_tetrahedron(depth) - sampled(depth)).lpNorm<Eigen::Infinity>(), kSpacing) << depth.transpose();
    EXPECT_LT((cut_tetrahedron(depth) + cut_tetrahedron(-depth) - Eigen::Vector4d::Constant(0.25)).norm(), 1e-14);
  }
}

TEST(CutTetrahedron, IsAllOrNothingWhereTheSignIsOne) {
  EXPECT_EQ(cut_tetrahedron(Eigen::Vector4d(1, 2, 3, 4)), Eigen::Vector4d::Constant(0.25));
  EXPECT_EQ(cut_tetrahedron(Eigen::Vector4d(-1, -2, 0, -4)), Eigen::Vector4d::Zero());
  EXPECT_NEAR(cut_tetrahedron(Eigen::Vector4d(1, -1, -1, -1)).sum(), 0.125, 1e-15);
}

}  // namespace
}  // namespace kt
