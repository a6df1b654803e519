// Tools that move and turn, against where they really are at many times of the step.
#include "collision/held/moving_tool.hpp"

#include <gtest/gtest.h>

#include "collision/held/first_contact.hpp"
#include "collision/shape/closest_point.hpp"
#include "tests/support/random_sample.hpp"
#include "tests/support/tool_shapes.hpp"

namespace kt {
namespace {

/// Whether the segment p q goes through the triangle a b c.
bool is_pierced(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto side = [](const Vec3& u, const Vec3& v, const Vec3& w, const Vec3& x) {
    return (v - u).cross(w - u).dot(x - u) > 0;
  };
  return side(a, b, c, p) != side(a, b, c, q) && side(p, q, a, b) == side(p, q, b, c) &&
         side(p, q, b, c) == side(p, q, c, a);
}

/// Distance of the turned core from a triangle; 0 where they intersect.
double core_distance(const ToolShape& tool, const Vec3& x, const Quaternion& r, const Vec3 (&t)[3]) {
  std::vector<Vec3> corners;
  for (const Vec3& c : tool.corners) corners.push_back(x + r * c);
  double best = 1e300;
  for (const Vec3& c : corners) best = std::min(best, closest_point_on_triangle(c, t[0], t[1], t[2]).distance_sq);
  best = std::sqrt(best);
  const auto edge = [&](int i, int k) {
    for (int c = 0; c < 3; ++c) {
      const Vec3 &a = corners[i], &b = corners[k], &p = t[c], &q = t[(c + 1) % 3];
      if (is_pierced(a, b, t[0], t[1], t[2])) best = 0;
      const auto [s, u] = closest_parameters(a, b, p, q);
      best = std::min(best, (a + s * (b - a) - p - u * (q - p)).norm());
    }
  };
  if (tool.triangles.empty()) edge(0, 1);
  for (const Triangle& face : tool.triangles) {
    for (int c = 0; c < 3; ++c) {
      edge(face[c], face[(c + 1) % 3]);
      if (is_pierced(t[c], t[(c + 1) % 3], corners[face[0]], corners[face[1]], corners[face[2]])) best = 0;
    }
    for (const Vec3& p : t)
      best = std::min(
          best,
          std::sqrt(closest_point_on_triangle(p, corners[face[0]], corners[face[1]], corners[face[2]]).distance_sq));
  }
  return best;
}

class MovingTools : public testing::TestWithParam<int> {
 protected:
  ToolShape shape() const { return GetParam() == 0 ? make_capsule(0.1, 0.8) : box_tool({0.3, 0.2, 0.1}, 1, 0.05); }
};

TEST_P(MovingTools, AreStoppedBeforeTheyTouchHoweverTheyTurn) {
  const ToolShape tool = shape();
  MovingTool moving(tool);
  Sample s{std::mt19937_64(11)};
  // A turn of 0.6 rad takes the corners off their chords by 4 % of their arm.
  const double swell = sagitta(tool_reach(tool) - tool.radius, 0.6) + 1e-9;
  int hits = 0;
  double early = 0;
  for (int i = 0; i < 1500; ++i) {
    Vec3 t0[3], t1[3];
    const Vec3 shift = 0.2 * s.cube();
    for (int c = 0; c < 3; ++c) {
      t0[c] = s.cube();
      t1[c] = t0[c] + shift + 0.2 * s.cube();
    }
    const Vec3 from = 1.6 * s.cube(), to = 0.8 * s.cube();
    const Quaternion r_t0 = Quaternion(Eigen::AngleAxisd(3 * s.uniform(0, 1), s.cube().normalized()));
    const Quaternion r_t1 = Quaternion(Eigen::AngleAxisd(0.6 * s.uniform(0, 1), s.cube().normalized())) * r_t0;
    const auto distance = [&](double t) {
      const Vec3 now[3] = {t0[0] + t * (t1[0] - t0[0]), t0[1] + t * (t1[1] - t0[1]), t0[2] + t * (t1[2] - t0[2])};
      return core_distance(tool, from + t * (to - from), r_t0.slerp(t, r_t1), now);
    };
    if (distance(0) < tool.radius + swell) continue;  // else it may count as touching already
    moving.move({from, to, r_t0, r_t1});
    auto hit = find_tool_impact(moving, t0, t1);
    const Vec3 back_t0[3] = {t0[0], t0[2], t0[1]}, back_t1[3] = {t1[0], t1[2], t1[1]};  // from either side
    if (const auto back = find_tool_impact(moving, back_t0, back_t1); back && (!hit || back->toi < hit->toi))
      hit = back;
    const double until = hit ? hit->toi : 1;
    for (int k = 0; k <= 60; ++k) ASSERT_GE(distance(until * k / 60.0) - tool.radius, -1e-11) << i << " at " << k;
    if (!hit) continue;
    ++hits;
    early = std::max(early, distance(hit->toi) - tool.radius);
  }
  EXPECT_GT(hits, 300);
  EXPECT_LT(early, 2 * swell);
}

TEST_P(MovingTools, NameTheSameContactWithEveryIndexAndAsOneByOne) {
  MovingTool moving(shape());
  Sample s{std::mt19937_64(5)};
  std::vector<Triangle> triangles;
  VectorX x(9 * 60), y;
  for (int i = 0; i < 60; ++i) {
    triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    const Vec3 at = 2 * s.cube();
    for (int c = 0; c < 3; ++c) node(x, 3 * i + c) = at + 0.4 * s.cube();
  }
  int hits = 0;
  for (int k = 0; k < 100; ++k) {
    y = x;
    for (int i = 0; i < y.size(); ++i) y[i] += 0.1 * (s.uniform(0, 1) - 0.5);
    moving.move({2 * s.cube(), 2 * s.cube(), Quaternion::Identity(),
                 Quaternion(Eigen::AngleAxisd(0.3, s.cube().normalized()))});
    std::optional<Contact> expected;
    for (int t = 0; t < 60; ++t) {
      const Vec3 t0[3] = {node(x, 3 * t), node(x, 3 * t + 1), node(x, 3 * t + 2)};
      const Vec3 t1[3] = {node(y, 3 * t), node(y, 3 * t + 1), node(y, 3 * t + 2)};
      auto hit = find_tool_impact(moving, t0, t1);
      if (!hit || (expected && expected->toi <= hit->toi)) continue;
      expected = hit;
      expected->triangle = t;
    }
    hits += expected.has_value();
    std::vector<int> scratch(60);
    for (const BackendInfo& backend : triangle_index_backends()) {
      if (!backend.available) continue;
      const auto index = make_triangle_index(backend.name);
      index->build(triangles, x);
      index->refit(x, y);
      EXPECT_EQ(find_first_contact(*index, {triangles, x, y}, moving, {}, scratch), expected) << backend.name;
    }
  }
  EXPECT_GT(hits, 20);
}

INSTANTIATE_TEST_SUITE_P(Shapes, MovingTools, testing::Values(0, 1),
                         [](const auto& p) { return p.param == 0 ? "capsule" : "box"; });

TEST(MovingTool, KnowsTheWayOfItsPoints) {
  MovingTool tool(make_capsule(0.1, 1));
  const Quaternion r(Eigen::AngleAxisd(0.5, Vec3::UnitX()));
  tool.move({{1, 2, 3}, {1.5, 2, 3}, Quaternion::Identity(), r});
  const Vec3 end = Vec3(1.5, 2, 3) + r * Vec3(0, 0, 0.5);
  EXPECT_NEAR((tool.way(end) - (end - Vec3(1, 2, 3.5))).norm(), 0, 1e-15);
  EXPECT_NEAR((tool.core().corners[1] - end).norm(), 0, 1e-15);
  const ToolSweep rest = rest_of(tool.sweep(), 0.5);
  EXPECT_NEAR((rest.x_t0 - Vec3(1.25, 2, 3)).norm(), 0, 1e-15);
  EXPECT_NEAR(rest.r_t0.angularDistance(Quaternion(Eigen::AngleAxisd(0.25, Vec3::UnitX()))), 0, 1e-7);
  EXPECT_NEAR(tool_reach(tool.shape()), 0.6, 1e-15);
}

}  // namespace
}  // namespace kt
