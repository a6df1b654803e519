// The check of a tool against the whole body sees what the local model does not have.
#include "haptics/tick/body_check.hpp"

#include <gtest/gtest.h>

#include "haptics/link/motion_record.hpp"
#include "tests/support/haptics_body.hpp"

namespace kt {
namespace {

/// A block with a small patch on its upper side, and a look at a tool that goes along a line.
class Look {
 public:
  explicit Look(const ToolShape& tool) : check_(body_.surface, {&tool, 1}) {
    const Bounds box = bounds(body_.model->mesh());
    top_ = box.max.z();
    low_ = box.min;
    high_ = box.max;
    model_ = body_.local_model({box.min.x() + 0.01, box.centre().y(), top_});
    model_->body_x = body_.model->mesh().x;
    check_.take(*model_);
    check_.place(model_->state.q);
  }
  double depth(const Vec3& at) { return check_.depth(0, {at, at}); }
  bool goes_through(const Vec3& from, const Vec3& to) { return check_.went_through(0, {from, to}); }
  const PreparedLocalModel& model() const { return *model_; }
  double top() const { return top_; }
  Vec3 middle() const { return 0.5 * (low_ + high_); }
  Vec3 far_end() const { return {high_.x() - 0.01, middle().y(), top_}; }
  const Vec3& high() const { return high_; }

 private:
  SoftBlock body_{{.reach = 0.006}};
  BodyCheck check_;
  std::unique_ptr<PreparedLocalModel> model_;
  double top_ = 0;
  Vec3 low_, high_;
};

TEST(BodyCheck, SeesABallInTheBodyFarFromThePatch) {
  Look look(kSphereTool);
  ASSERT_LT(look.model().surface.facets.triangles.size(), 100u) << "the patch is not small";
  const double r = kSphereTool.radius;
  EXPECT_EQ(look.depth(look.far_end() + Vec3(0, 0, r + 1e-4)), 0);
  EXPECT_NEAR(look.depth(look.far_end() + Vec3(0, 0, r - 1e-3)), 1e-3, 1e-12);
  EXPECT_NEAR(look.depth(look.far_end() - Vec3(0, 0, 2e-3)), r + 2e-3, 1e-12);
  EXPECT_EQ(look.depth(look.far_end() + Vec3(0, 0, 1)), 0) << "from far away, too";
}

TEST(BodyCheck, FollowsAToolThatMovesALittleEachTime) {
  Look look(kSphereTool);
  const double r = kSphereTool.radius;
  for (double height = 0.05; height > r - 2e-3; height -= 1e-4)
    ASSERT_NEAR(look.depth(look.far_end() + Vec3(0, 0, height)), std::max(0.0, r - height), 1e-12) << height;
}

TEST(BodyCheck, SeesAToolThatGoesThroughInOneTick) {
  for (const ToolShape& tool : {kPointTool, kSphereTool}) {
    Look look(tool);
    const Vec3 up(0, 0, 0.5), down(0, 0, -0.5);
    EXPECT_TRUE(look.goes_through(look.middle() + up, look.middle() + down));
    EXPECT_TRUE(look.goes_through(look.far_end() + up, look.far_end() + down)) << "far from the patch";
    const Vec3 aside(0.5, 0, 0);
    EXPECT_FALSE(look.goes_through(look.middle() + up + aside, look.middle() + down + aside));
    EXPECT_FALSE(look.goes_through(look.far_end() + up, look.far_end() + 0.5 * up));
  }
}

/// Where a rounding would let a ray slip between two triangles.
TEST(BodyCheck, SeesAToolThatGoesThroughEdgesAndCornersExactly) {
  Look look(kPointTool);
  const SurfacePatch& facets = look.model().surface.facets;
  const VectorX& x = look.model().work.x;
  int seen = 0;
  for (std::size_t t = 0; t < facets.triangles.size(); ++t) {
    const Triangle& v = facets.triangles[t];
    const Vec3 a = node(x, v[0]), b = node(x, v[1]);
    if (a.z() != look.top() || b.z() != look.top()) continue;
    for (const Vec3& at : {a, b, Vec3(0.5 * (a + b))}) {
      EXPECT_TRUE(look.goes_through(at + Vec3(0, 0, 0.5), at - Vec3(0, 0, 0.5))) << at.transpose();
      ++seen;
    }
  }
  EXPECT_GT(seen, 10);
  const Vec3 corner = look.high();
  EXPECT_TRUE(look.goes_through(corner + Vec3(0, 0, 0.5), corner - Vec3(0, 0, 0.5))) << "down an edge of the body";
}

TEST(MotionRecord, GivesBackWhatWasPutInOverManyRounds) {
  constexpr int kRoom = 2 * (20 + 16 * kMaxTools);
  MotionRecord record(kRoom);
  MotionRecord::Tick tick;
  VectorX q;
  EXPECT_FALSE(record.front(tick, q));
  int put = 0, got = 0;
  const auto made = [](int i) { return VectorX(VectorX::Constant(1 + i % 6, i)); };
  while (got < 200) {
    MotionRecord::Tick next{put, put / 7, {}};
    for (next.tools[1] = {{{1, 2, put * 1.0}}, {{3, 4, 5}, {0, 1, 0, 0}}, put % 2 == 0, 0.1 * put};
         record.push(next, made(put)); next.tools[1].is_free = put % 2 == 0) {
      next.tick = ++put;
      next.frame = put / 7;
      next.tools[1].from.x.z() = put;
      next.tools[1].gap = 0.1 * put;
    }
    ASSERT_GT(put, got);
    while (record.front(tick, q)) {
      ASSERT_EQ(tick.tick, got);
      ASSERT_EQ(tick.frame, got / 7);
      ASSERT_EQ(q, made(got));
      const MotionRecord::Way& way = tick.tools[1];
      ASSERT_EQ(way.from, (Pose{{1, 2, got * 1.0}}));
      ASSERT_EQ(way.to, (Pose{{3, 4, 5}, {0, 1, 0, 0}}));
      ASSERT_EQ(way.is_free, got % 2 == 0);
      ASSERT_EQ(way.gap, 0.1 * got);
      record.pop();
      ++got;
    }
  }
  EXPECT_FALSE(record.push({}, VectorX::Zero(kRoom))) << "larger than all of it";
}

}  // namespace
}  // namespace kt
