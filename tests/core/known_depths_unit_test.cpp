// Depths that are kept are those of the field, whatever was asked before.
#include "core/fine/known_depths.hpp"

#include <gtest/gtest.h>

#include <random>

namespace kt {
namespace {

/// Material below a plane, and how often it was asked.
class BelowPlane final : public MaterialField {
 public:
  bool is_whole(int /*cell*/) const override { return false; }
  double depth(int cell, const Vec3& place, double most) const override {
    ++asked;
    return std::clamp(0.3 + 0.01 * cell - place.z(), -most, most);
  }
  mutable int asked = 0;
};

TEST(KnownDepths, AreTheFieldsWhateverWasAskedBefore) {
  VectorX x(12);
  x << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  std::vector<CellPoint> points;
  for (int i = 0; i < 4; ++i) points.push_back(corner_point(i));
  for (int i = 0; i < 60; ++i)
    points.push_back(middle(points[static_cast<std::size_t>(i)], points[static_cast<std::size_t>(i / 2)]));
  const BelowPlane field;
  KnownDepths known(field, x);
  std::mt19937 random(5);
  const double mosts[] = {0.01, 0.1, 0.2, 1.0};
  constexpr int kQuestions = 3000;
  for (int k = 0; k < kQuestions; ++k) {
    const int cell = static_cast<int>(random() % 3);
    const CellPoint& point = points[random() % points.size()];
    const double most = mosts[random() % 4];
    EXPECT_EQ(known.at(cell, point, most), BelowPlane().depth(cell, point.of(x), most));
  }
  EXPECT_LE(known.size(), 3 * points.size());
  EXPECT_LT(field.asked, kQuestions / 4) << "each place once, as a rule";
}

}  // namespace
}  // namespace kt
