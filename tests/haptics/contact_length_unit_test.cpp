#include "haptics/touched/contact_length.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace kt {
namespace {

const Quaternion kLying(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec3::UnitX()));  // along -y

/// Places 1 mm apart along y up to `half_length`, and 0.2 mm apart along x up to `half_width`; pressure is even along y
/// and half an ellipse along x.
std::vector<TickContact> contacts(double half_length, double half_width, int tool = 0) {
  constexpr int kAcross = 20;
  std::vector<TickContact> out;
  const int along = static_cast<int>(std::lround(half_length / 0.0005));
  for (int i = 0; i < along; ++i)
    for (int j = 0; j < kAcross; ++j) {
      const double u = (j + 0.5) / kAcross * 2 - 1;
      out.push_back({.impulse = Vec3(0, 0, -std::sqrt(1 - u * u)),
                     .normal = Vec3::UnitZ(),
                     .point = Vec3(0.1 + half_width * u, half_length * ((i + 0.5) / along * 2 - 1), 0),
                     .tool = tool});
    }
  return out;
}

TEST(ContactLength, IsThatOfTheContactAndSoIsItsWidth) {
  const auto found = contact_length(make_capsule(0.004, 0.02), kLying, contacts(0.01, 0.002), 0);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->half_length, 0.01, 2e-5);
  EXPECT_NEAR(found->half_width, 0.002, 2e-5);
  EXPECT_NEAR(std::abs(found->along.y()), 1, 1e-12);
  EXPECT_NEAR((found->middle - Vec3(0.1, 0, 0)).norm(), 0, 1e-12);
}

TEST(ContactLength, IsNoneOfARoundContactAnotherShapeAnotherToolOrAnUprightOne) {
  const ToolShape capsule = make_capsule(0.004, 0.02);
  EXPECT_FALSE(contact_length(capsule, kLying, contacts(0.003, 0.002), 0));
  EXPECT_FALSE(contact_length({ToolShape::Kind::sphere, 0.004}, kLying, contacts(0.01, 0.002), 0));
  EXPECT_FALSE(contact_length(capsule, kLying, contacts(0.01, 0.002, 1), 0));
  EXPECT_FALSE(contact_length(capsule, Quaternion::Identity(), contacts(0.01, 0.002), 0));
  EXPECT_FALSE(contact_length(capsule, kLying, {}, 0));
}

}  // namespace
}  // namespace kt
