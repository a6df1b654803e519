// Held contacts of tools on surfaces whose answer is known.
#include "collision/held/tool_contacts.hpp"

#include <gtest/gtest.h>

#include "core/local/reducer.hpp"
#include "tests/support/dense_tool_contacts.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/random_sample.hpp"
#include "tests/support/tool_shapes.hpp"

namespace kt {
namespace {

/// A grid of n x n quads of 1 mm over z = height(x, y), seen from above.
template <class Height>
Mesh grid(int n, const Height& height) {
  Mesh mesh;
  mesh.x.resize(3 * (n + 1) * (n + 1));
  for (int i = 0; i <= n; ++i)
    for (int k = 0; k <= n; ++k) {
      const double x = 1e-3 * (i - 0.5 * n), y = 1e-3 * (k - 0.5 * n);
      node(mesh.x, i * (n + 1) + k) = Vec3(x, y, height(x, y));
      if (i == n || k == n) continue;
      const int a = i * (n + 1) + k, b = a + n + 1;
      mesh.triangles.push_back({a, b, b + 1});
      mesh.triangles.push_back({a, b + 1, a + 1});
    }
  return mesh;
}

struct Scene {
  Mesh mesh;
  Surface surface = make_surface(mesh);
  SurfacePatch patch = make_patch(surface, mesh.x, {Vec3::Zero(), 0, 1});

  ContactSet contacts(const ToolShape& tool, const Vec3& at, const Quaternion& turn = Quaternion::Identity(),
                      double margin = 1e-4) const {
    MovingTool moving(tool);
    moving.move({at, at, turn, turn});
    std::vector<int> all(patch.triangles.size());
    for (int t = 0; t < static_cast<int>(all.size()); ++t) all[static_cast<std::size_t>(t)] = t;
    ContactSet out;
    VectorX x(3 * patch.num_vertices());
    for (int i = 0; i < patch.num_vertices(); ++i) node(x, i) = node(mesh.x, patch.global_node[i]);
    NearFeatures near(static_cast<int>(all.size()), patch.num_vertices());
    find_tool_contacts(patch, x, moving.core(), tool.radius, margin, all, -1, near, out);
    return out;
  }
};

const Quaternion kLying(Eigen::AngleAxisd(M_PI / 2, Vec3::UnitY()));  // a capsule along x

TEST(ToolContacts, OfACapsuleThatLiesHoldBothItsEnds) {
  const Scene plane{grid(20, [](double, double) { return 0.0; })};
  const ContactSet set = plane.contacts(make_capsule(2e-3, 8e-3), {1.3e-4, 2.1e-4, 1.99e-3}, kLying);
  ASSERT_GE(set.count, 2);
  double low = 1, high = -1;
  for (const Contact& c : set) {
    EXPECT_NEAR(c.gap, -1e-5, 1e-12);
    EXPECT_NEAR((c.normal - Vec3::UnitZ()).norm(), 0, 1e-9);
    low = std::min(low, c.core.x());
    high = std::max(high, c.core.x());
  }
  EXPECT_NEAR(high - low, 8e-3, 1e-9);
}

TEST(ToolContacts, OfATiltedCapsuleAreAtItsLowerEnd) {
  const Scene plane{grid(20, [](double, double) { return 0.0; })};
  const Quaternion tilted(Eigen::AngleAxisd(M_PI / 3, Vec3::UnitY()));
  const ContactSet set = plane.contacts(make_capsule(2e-3, 8e-3), {0, 0, 2e-3 + 4e-3 * 0.5 - 1e-5}, tilted);
  ASSERT_EQ(set.count, 1);
  EXPECT_NEAR(set.contacts[0].gap, -1e-5, 1e-12);
  EXPECT_NEAR(set.contacts[0].core.z(), 2e-3 - 1e-5, 1e-12);
}

TEST(ToolContacts, OfACapsuleAcrossARidgeAreOnTheRidge) {
  const Scene ridge{grid(20, [](double x, double) { return -std::abs(x); })};
  const ContactSet set = ridge.contacts(make_capsule(2e-3, 8e-3), {5e-4, 3e-4, 1.99e-3}, kLying);
  ASSERT_EQ(set.count, 1);
  EXPECT_NEAR(set.contacts[0].core.x(), 0, 1e-12);
  EXPECT_NEAR(set.contacts[0].gap, -1e-5, 1e-9);
  EXPECT_NEAR((set.contacts[0].normal - Vec3::UnitZ()).norm(), 0, 1e-6);
}

TEST(ToolContacts, OfACapsuleInAValleyAreOnBothSlopes) {
  const Scene valley{grid(20, [](double x, double) { return std::abs(x); })};
  const double r = 2e-3;
  const Quaternion along_y(Eigen::AngleAxisd(-M_PI / 2, Vec3::UnitX()));
  const ContactSet set = valley.contacts(make_capsule(r, 8e-3), {0, 2e-4, std::sqrt(2) * r - 1e-5}, along_y);
  bool left = false, right = false;
  for (const Contact& c : set) {
    EXPECT_NEAR(c.gap, -1e-5 / std::sqrt(2), 1e-9);
    left |= c.normal.x() > 0.7;
    right |= c.normal.x() < -0.7;
  }
  EXPECT_TRUE(left && right);
}

TEST(ToolContacts, OfABoxOnASpikeAreUnderItsFace) {
  const Scene spike{grid(20, [](double x, double y) { return -3 * std::hypot(x, y); })};
  const ContactSet set =
      spike.contacts(box_tool({5e-3, 5e-3, 1e-3}, 1, 5e-4), {1.1e-3, 7e-4, 1.49e-3}, Quaternion::Identity(), 2e-5);
  ASSERT_EQ(set.count, 1);
  EXPECT_NEAR(set.contacts[0].gap, -1e-5, 1e-9);
  EXPECT_NEAR((set.contacts[0].core - Vec3(0, 0, 4.9e-4)).norm(), 0, 1e-9);
}

TEST(ToolContacts, OfABoxThatLiesSpreadToItsCorners) {
  const Scene plane{grid(20, [](double, double) { return 0.0; })};
  const ContactSet set = plane.contacts(box_tool({4e-3, 3e-3, 1e-3}, 1, 5e-4), {1.3e-4, 2.1e-4, 1.49e-3});
  Vec3 low = Vec3::Ones(), high = -low;
  for (const Contact& c : set) {
    EXPECT_NEAR(c.gap, -1e-5, 1e-12);
    low = low.cwiseMin(c.core);
    high = high.cwiseMax(c.core);
  }
  EXPECT_NEAR((high - low - Vec3(8e-3, 6e-3, 0)).norm(), 0, 1e-9);
}

/// None inside another part of the tool: whatever is reported, a ball there is the tool's.
TEST(ToolContacts, AreWhereTheToolIsNearest) {
  Sample s{std::mt19937_64(3)};
  const Scene bumpy{grid(16, [&](double, double) { return 4e-4 * s.uniform(-1, 1); })};
  for (const ToolShape& tool : {make_capsule(1.5e-3, 6e-3), box_tool({2e-3, 3e-3, 1e-3}, 2, 5e-4)})
    for (int i = 0; i < 100; ++i) {
      const Quaternion turn(Eigen::AngleAxisd(s.uniform(0, 3), s.cube().normalized()));
      const Vec3 at(1e-3 * s.uniform(-2, 2), 1e-3 * s.uniform(-2, 2), s.uniform(1e-3, 5e-3));
      const ContactSet set = bumpy.contacts(tool, at, turn, 1e-3);
      for (const Contact& c : set) {
        const Triangle& v = bumpy.patch.triangles[c.triangle];
        Vec3 place = Vec3::Zero();
        for (int k = 0; k < 3; ++k) place += c.bary[k] * node(bumpy.mesh.x, bumpy.patch.global_node[v[k]]);
        EXPECT_NEAR((place + (tool.radius + c.gap) * c.normal - c.core).norm(), 0, 1e-12);
      }
    }
}

/// What all pairs of triangles and features find is told by what is looked at once: nothing that is found is not there,
/// and nowhere on a triangle is the tool deeper than somewhere on it or on a neighbour among those found.
TEST(ToolContacts, TellAsMuchAsAllPairsDo) {
  constexpr double kRoundoff = 1e-12, kDeepest = 1e-4;  // [m]
  Sample s{std::mt19937_64(5)};
  const Scene bumpy{grid(16, [&](double, double) { return 2e-4 * s.uniform(-1, 1); })};
  const Scene plane{grid(16, [](double, double) { return 0.0; })};
  int found = 0, pairs = 0;
  for (const Scene* body : {&bumpy, &plane})
    for (const ToolShape& tool : {make_capsule(1.5e-3, 6e-3), box_tool({2e-3, 3e-3, 1e-3}, 3, 5e-4),
                                  ball_tool(3e-3, 5, 5e-4), box_tool({2e-3, 3e-3, 1e-3}, 1, 5e-4)})
      for (int i = 0; i < 200; ++i) {
        const double turned = i % 3 == 0 ? 0.0 : s.uniform(0, 3);  // a third lies flat, or stands
        const Quaternion turn(Eigen::AngleAxisd(turned, s.cube().normalized()));
        const Vec3 at(1e-3 * s.uniform(-2, 2), 1e-3 * s.uniform(-2, 2), s.uniform(1e-3, 5e-3));
        MovingTool moving(tool);
        moving.move({at, at, turn, turn});
        const double margin = 1e-4;
        const ContactSet set = body->contacts(tool, at, turn, margin);
        if (set.count == kMaxContacts) continue;  // some had no room
        VectorX x(3 * body->patch.num_vertices());
        for (int v = 0; v < body->patch.num_vertices(); ++v)
          node(x, v) = node(body->mesh.x, body->patch.global_node[v]);
        const std::vector<Contact> all = contacts_by_triangles(body->patch, x, moving.core(), tool.radius, margin);
        const auto deepest = std::ranges::min_element(all, {}, &Contact::gap);
        if (deepest == all.end() || deepest->gap < -kDeepest) continue;  // a tick's are less deep by far
        const auto is_next_to = [&](const Contact& a, const Contact& b) {
          const Triangle &ta = body->patch.triangles[a.triangle], &tb = body->patch.triangles[b.triangle];
          return std::ranges::find_first_of(ta, tb) != ta.end();
        };
        for (const Contact& c : all)
          EXPECT_TRUE(std::any_of(set.begin(), set.end(),
                                  [&](const Contact& b) { return b.gap <= c.gap + kRoundoff && is_next_to(c, b); }))
              << "a gap of " << c.gap << " at triangle " << c.triangle << " is told by none of " << set.count;
        for (const Contact& c : set) {
          const auto again = find_sphere_contact(body->patch, x, c.core, tool.radius, margin, c.triangle);
          ASSERT_TRUE(again);
          EXPECT_NEAR(again->gap, c.gap, kRoundoff);
          EXPECT_NEAR((again->normal - c.normal).norm(), 0, 1e-9);
        }
        found += set.count;
        pairs += static_cast<int>(all.size());
      }
  EXPECT_GT(found, 200);
  EXPECT_LT(2 * found, pairs);
}

/// Features that are remembered while the surface moves give the contacts that a search from anew gives.
TEST(ToolContacts, AreTheSameFromRememberedFeatures) {
  Sample s{std::mt19937_64(6)};
  const Scene bumpy{grid(16, [&](double, double) { return 2e-4 * s.uniform(-1, 1); })};
  const SurfacePatch& patch = bumpy.patch;
  std::vector<int> all(patch.triangles.size());
  for (int t = 0; t < static_cast<int>(all.size()); ++t) all[static_cast<std::size_t>(t)] = t;
  const int facets = static_cast<int>(all.size()), vertices = patch.num_vertices();
  int found = 0, kept = 0;
  for (const ToolShape& tool : {make_capsule(1.5e-3, 6e-3), box_tool({2e-3, 3e-3, 1e-3}, 3, 5e-4)})
    for (int i = 0; i < 40; ++i) {
      const Quaternion turn(Eigen::AngleAxisd(s.uniform(0, 3), s.cube().normalized()));
      const Vec3 at(1e-3 * s.uniform(-2, 2), 1e-3 * s.uniform(-2, 2), s.uniform(1e-3, 4e-3));
      MovingTool moving(tool);
      moving.move({at, at, turn, turn});
      NearFeatures near(facets, vertices);
      VectorX x = bumpy.mesh.x;
      for (int v = 0; v < vertices; ++v) node(x, v) = node(bumpy.mesh.x, patch.global_node[v]);
      for (int step = 0; step < 12; ++step) {
        ContactSet remembered, anew;
        NearFeatures nothing(facets, vertices);
        const VectorX before = near.x;
        find_tool_contacts(patch, x, moving.core(), tool.radius, 1e-4, all, -1, near, remembered);
        find_tool_contacts(patch, x, moving.core(), tool.radius, 1e-4, all, -1, nothing, anew);
        kept += step > 0 && before == near.x;
        ASSERT_EQ(remembered.count, anew.count);
        for (int c = 0; c < anew.count; ++c) EXPECT_EQ(remembered.contacts[c], anew.contacts[c]);
        found += anew.count;
        for (Eigen::Index k = 0; k < x.size(); ++k) x[k] += 2e-5 * s.uniform(-1, 1);
      }
    }
  EXPECT_GT(found, 500);
  EXPECT_GT(kept, 100);
  EXPECT_LT(kept, 2 * 40 * 11);
}

}  // namespace
}  // namespace kt
