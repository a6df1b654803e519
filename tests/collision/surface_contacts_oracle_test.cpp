// Contacts of tools at rest against brute force, winding numbers and closed forms.
#include "collision/held/surface_contacts.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "tests/support/collision_surfaces.hpp"
#include "tests/support/random_sample.hpp"

namespace kt {
namespace {

const char* const kClosedMeshes[] = {"sphere.off",      "torus.off",  "organ.off",
                                     "slab_coarse.off", "genus5.off", "sheet.off"};

/// A point within `reach` of the surface, half of them next to a vertex or an edge.
Vec3 point_near(Sample& s, const TestSurface& surface, double reach) {
  const Triangle& t = surface.patch.triangles[s.random() % surface.patch.triangles.size()];
  Vec3 w(s.uniform(0, 1), s.uniform(0, 1), s.uniform(0, 1));
  if (s.uniform(0, 1) < 0.25) w[1] = 0;
  if (s.uniform(0, 1) < 0.25) w[2] = 0;
  w /= w.sum();
  return w[0] * node(surface.x, t[0]) + w[1] * node(surface.x, t[1]) + w[2] * node(surface.x, t[2]) + reach * s.cube();
}

TEST(NearestPointContact, IsTheSignedDistanceOfEveryMesh) {
  Sample s{std::mt19937_64(31)};
  for (const char* name : kClosedMeshes) {
    const TestSurface surface = load_test_surface(name);
    for (int i = 0; i < 400; ++i) {
      const Vec3 p = point_near(s, surface, i % 2 ? 0.02 : 0.001);
      const Contact contact = nearest_point_contact(surface.patch, surface.x, p);
      const double distance = distance_to(surface, p);
      EXPECT_NEAR(std::abs(contact.gap), distance, 1e-15) << name;
      if (distance > 1e-9) {
        EXPECT_EQ(contact.gap > 0, winding_number(surface, p) < 0.5) << name << " " << i << " gap " << contact.gap;
      }
      const ClosestPoint at = closest_on(surface, contact.triangle, p);
      EXPECT_EQ(contact.bary, at.bary);
      EXPECT_NEAR(contact.normal.norm(), 1, 1e-14);
    }
  }
}

TEST(NearestPointContact, IsTheClosedFormOfSphereAndTorus) {
  Sample s{std::mt19937_64(32)};
  const TestSurface sphere = load_test_surface("sphere.off"), torus = load_test_surface("torus.off");
  // Facets lie inside the round body by at most h^2 / 8 r for edges of length h: 5 mm on 30 mm, 8 mm on 15 mm.
  constexpr double kSphereSag = 1.5e-4, kTorusSag = 6e-4;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p = 0.06 * s.cube();
    EXPECT_NEAR(nearest_point_contact(sphere.patch, sphere.x, p).gap, p.norm() - 0.03, kSphereSag);
    const double ring = std::hypot(std::hypot(p.x(), p.y()) - 0.04, p.z());
    EXPECT_NEAR(nearest_point_contact(torus.patch, torus.x, p).gap, ring - 0.015, kTorusSag);
  }
}

TEST(TrackPointContact, FindsTheNearestFromANeighbour) {
  Sample s{std::mt19937_64(33)};
  for (const char* name : kClosedMeshes) {
    const TestSurface surface = load_test_surface(name);
    for (int i = 0; i < 300; ++i) {
      const Vec3 p = point_near(s, surface, 3e-4);
      const Contact nearest = nearest_point_contact(surface.patch, surface.x, p);
      const auto& triangle = surface.patch.triangles[static_cast<std::size_t>(nearest.triangle)];
      for (const int v : triangle)
        for (const int start : surface.patch.topology.triangles_of(v)) {
          const Contact contact = track_point_contact(surface.patch, surface.x, p, start);
          EXPECT_NEAR(contact.gap, nearest.gap, 1e-15) << name << " " << i;
        }
    }
  }
}

TEST(NearestPointContact, IsOutsideOfASpikeWhoseTopHasManyTriangles) {
  // A flat spike with its tip at the origin; an unweighted sum of normals would point up, away from the point below.
  constexpr int kTop = 10;
  VectorX x(3 * (kTop + 4));
  node(x, 0).setZero();
  for (int i = 0; i <= kTop; ++i) node(x, i + 1) = Vec3(-1, 0.06 * i - 0.3, 0.02);
  node(x, kTop + 2) = Vec3(-1, -0.3, -0.02);
  node(x, kTop + 3) = Vec3(-1, 0.3, -0.02);
  std::vector<Triangle> triangles = {{0, kTop + 2, kTop + 3}, {0, 1, kTop + 2}, {0, kTop + 3, kTop + 1}};
  for (int i = 0; i < kTop; ++i) triangles.push_back({0, i + 2, i + 1});
  const TestSurface spike = make_test_surface(triangles, x);
  const Vec3 below(0.05, 0, -1);
  EXPECT_NEAR(nearest_point_contact(spike.patch, spike.x, below).gap, below.norm(), 1e-15);
}

TEST(TrackPointContact, StaysOnItsSideOfAThinBody) {
  const TestSurface sheet = load_test_surface("sheet.off");  // 2 mm thick
  double high = -1;
  for (Eigen::Index i = 2; i < sheet.x.size(); i += 3) high = std::max(high, sheet.x[i]);
  const Vec3 above(0.0513, 0.0487, high);
  const int start = nearest_point_contact(sheet.patch, sheet.x, above).triangle;
  for (double depth = 0; depth < 4e-3; depth += 1e-4) {
    const Contact contact = track_point_contact(sheet.patch, sheet.x, above - Vec3(0, 0, depth), start);
    EXPECT_NEAR(contact.gap, -depth, 1e-12);
    EXPECT_NEAR(contact.normal.z(), 1, 1e-12);
  }
}

TEST(BlendedNormal, IsContinuousOverEdgesButGrooves) {
  Sample s{std::mt19937_64(34)};
  int compared = 0;
  for (const char* name : kClosedMeshes) {
    const TestSurface surface = load_test_surface(name);
    for (int t = 0; t < static_cast<int>(surface.patch.triangles.size()); ++t)
      for (int e = 0; e < 3; ++e) {
        const Triangle& own = surface.patch.triangles[static_cast<std::size_t>(t)];
        const int other = surface.patch.topology.across[static_cast<std::size_t>(t)][static_cast<std::size_t>(e)];
        const Triangle& theirs = surface.patch.triangles[static_cast<std::size_t>(other)];
        const Vec3 n = face_normal(surface.patch, surface.x, t);
        const bool is_sharp = n.dot(face_normal(surface.patch, surface.x, other)) < 0.1;
        const auto far = [&](int v) { return n.dot(node(surface.x, v) - node(surface.x, own[0])) > 1e-6; };
        if (is_sharp && std::ranges::any_of(theirs, far)) continue;  // a groove
        ++compared;
        const double w = s.uniform(0, 1);
        Vec3 bary = Vec3::Zero(), same = Vec3::Zero();
        bary[e] = w;
        bary[(e + 1) % 3] = 1 - w;
        for (int k = 0; k < 3; ++k)
          for (int m = 0; m < 3; ++m)
            if (theirs[static_cast<std::size_t>(k)] == own[static_cast<std::size_t>(m)]) same[k] = bary[m];
        const Vec3 a = blended_normal(surface.patch, surface.x, t, bary);
        EXPECT_LT((a - blended_normal(surface.patch, surface.x, other, same)).norm(), 1e-14) << name;
        EXPECT_NEAR(a.norm(), 1, 1e-14);
      }
  }
  EXPECT_GT(compared, 10000);
}

// ---- spheres ----

std::vector<int> all_triangles(const TestSurface& s) {
  std::vector<int> out(s.patch.triangles.size());
  std::iota(out.begin(), out.end(), 0);
  return out;
}

ContactSet sphere_contacts(const TestSurface& s, const Vec3& centre, double radius, double margin = 0, int start = -1) {
  ContactSet out;
  find_sphere_contacts(s.patch, s.x, centre, radius, margin, all_triangles(s), start, out);
  return out;
}

/// Strip along y whose profile in the xz-plane runs over the given points from left to right; normals up.
TestSurface strip(const std::vector<std::pair<double, double>>& profile) {
  VectorX x(static_cast<Eigen::Index>(6 * profile.size()));
  std::vector<Triangle> triangles;
  for (int i = 0; i < static_cast<int>(profile.size()); ++i) {
    const auto [px, pz] = profile[static_cast<std::size_t>(i)];
    x.segment<6>(6 * i) << px, -1, pz, px, 1, pz;
    if (i > 0) {
      triangles.push_back({2 * i - 2, 2 * i, 2 * i + 1});
      triangles.push_back({2 * i - 2, 2 * i + 1, 2 * i - 1});
    }
  }
  return make_test_surface(triangles, x);
}

ContactSet point_contacts(const TestSurface& s, const Vec3& p) {
  ContactSet out;
  find_point_contacts(s.patch, s.x, p, nearest_point_contact(s.patch, s.x, p).triangle, out);
  return out;
}

TEST(PointContacts, AreBothWallsOfAGroove) {
  const TestSurface groove = strip({{-1, 1}, {0, 0}, {1, 1}});
  const double half = std::sqrt(0.5);
  // Clear of both, through the left one, and under the groove, where no wall is straight ahead.
  for (const Vec3& p : {Vec3(-0.2, 0.1, 0.3), Vec3(-0.3, 0.1, 0.2), Vec3(-0.01, 0.3, -0.02)}) {
    const ContactSet found = point_contacts(groove, p);
    ASSERT_EQ(found.count, 2) << p.transpose();
    for (const Contact& c : found) {
      const double side = c.normal.x() > 0 ? 1 : -1;  // the left wall looks to the right
      EXPECT_NEAR((c.normal - half * Vec3(side, 0, 1)).norm(), 0, 1e-15);
      EXPECT_NEAR(c.gap, half * (side * p.x() + p.z()), 1e-15);
    }
    EXPECT_LT(found.contacts[0].normal.dot(found.contacts[1].normal), 1e-15);
  }
}

TEST(PointContacts, AreOneOnARidgeInAShallowHollowAndBesideAWall) {
  EXPECT_EQ(point_contacts(strip({{-1, -1}, {0, 0}, {1, -1}}), {-0.01, 0.3, -0.02}).count, 1);
  EXPECT_EQ(point_contacts(strip({{-1, 0.2}, {0, 0}, {1, 0.2}}), {-0.01, 0.3, -0.02}).count, 1);
  // Two flights of stairs: on the upper step the wall ends below.
  const TestSurface stairs = strip({{-1, 0}, {0, 0}, {0, 1}, {1, 1}});
  EXPECT_EQ(point_contacts(stairs, {0.3, 0.2, 1.01}).count, 1);
  EXPECT_EQ(point_contacts(stairs, {-0.3, 0.2, 0.01}).count, 2);
}

/// Two planes that face away from one another, the upper one at z = 0.
TestSurface sheet(double thickness) {
  VectorX x(24);
  for (int side = 0; side < 2; ++side)
    x.segment<12>(12 * side) << -1, -1, -side * thickness, -1, 1, -side * thickness, 1, -1, -side * thickness, 1, 1,
        -side * thickness;
  return make_test_surface({{0, 2, 3}, {0, 3, 1}, {4, 7, 6}, {4, 5, 7}}, x);
}

TEST(SphereContacts, OfABallThatEndsFarBehindWhereItTouchedAreOnThatSide) {
  constexpr double kRadius = 0.1, kThickness = 0.05;
  const TestSurface thin = sheet(kThickness);
  // With its centre exactly on the surface; within the sheet; below it; more than its diameter below.
  for (const double z : {0.0, -0.5 * kThickness, -0.12, -0.4}) {
    const Vec3 centre(0.1, 0.2, z);
    ContactSet found;
    find_sphere_contacts(thin.patch, thin.x, centre, kRadius, 0, all_triangles(thin), 0, found,
                         Vec3(0, 0, z - 1.1 * kRadius));
    ASSERT_EQ(found.count, 1) << z;
    EXPECT_NEAR(found.contacts[0].normal.z(), 1, 1e-15) << z;
    EXPECT_NEAR(found.contacts[0].gap, z - kRadius, 1e-15) << z;
  }
  // Without a way that led there it is another ball, beside the far side or nowhere near.
  EXPECT_LT(sphere_contacts(thin, {0.1, 0.2, -0.12}, kRadius, 0, 0).contacts[0].normal.z(), 0);
  EXPECT_EQ(sphere_contacts(thin, {0.1, 0.2, -0.4}, kRadius, 0, 0).count, 0);
}

TEST(SphereContacts, OneOnAPlaneTwoInAGrooveThreeOnARidgeBetweenWalls) {
  const TestSurface plane = strip({{-1, 0}, {1, 0}});
  const ContactSet flat = sphere_contacts(plane, {0.1, 0.2, 0.24}, 0.25);
  ASSERT_EQ(flat.count, 1);
  EXPECT_NEAR(flat.contacts[0].gap, -0.01, 1e-15);
  EXPECT_NEAR(flat.contacts[0].normal.z(), 1, 1e-15);

  // Walls at 45 degrees, bottom at the origin: a sphere at height h is h / sqrt 2 from both.
  const TestSurface groove = strip({{-1, 1}, {0, 0}, {1, 1}});
  const double h = 0.3;
  const ContactSet two = sphere_contacts(groove, {0, 0.1, h}, 0.25);
  ASSERT_EQ(two.count, 2);
  for (const Contact& c : two) {
    EXPECT_NEAR(c.gap, h / std::sqrt(2) - 0.25, 1e-15);
    EXPECT_NEAR(c.normal.z(), 1 / std::sqrt(2), 1e-15);
  }
  EXPECT_NEAR(two.contacts[0].normal.x(), -two.contacts[1].normal.x(), 1e-15);

  // On the ridge the edge is touched, and each of the two neighbouring valleys' far walls.
  const TestSurface ridge = strip({{-1, 1}, {-0.5, 0}, {0, 0.5}, {0.5, 0}, {1, 1}});
  const ContactSet three = sphere_contacts(ridge, {0, 0.1, 0.75}, 0.2, 0.6);
  ASSERT_EQ(three.count, 3);
  EXPECT_EQ(std::count_if(three.begin(), three.end(), [](const Contact& c) { return c.normal.z() > 0.999; }), 1);
}

TEST(SphereContacts, ACornerIsTouchedOnce) {
  const TestSurface slab = load_test_surface("slab_coarse.off");
  const Vec3 out = Vec3(-1, -1, -1).normalized();
  const ContactSet contacts = sphere_contacts(slab, 0.009 * out, 0.01);
  ASSERT_EQ(contacts.count, 1);
  EXPECT_NEAR(contacts.contacts[0].gap, -0.001, 1e-15);
  EXPECT_LT((contacts.contacts[0].normal - out).norm(), 1e-12);
}

TEST(SphereContacts, AFarSideSeenThroughTheBodyIsNone) {
  const TestSurface sheet = load_test_surface("sheet.off");
  double high = -1;
  for (Eigen::Index i = 2; i < sheet.x.size(); i += 3) high = std::max(high, sheet.x[i]);
  const ContactSet contacts = sphere_contacts(sheet, {0.0513, 0.0487, high + 0.009}, 0.01, 0.01);
  ASSERT_EQ(contacts.count, 1);
  EXPECT_NEAR(contacts.contacts[0].gap, -0.001, 1e-12);
}

TEST(SphereContacts, ACentreThatHasGoneThroughIsPushedOutWhereItTouched) {
  const TestSurface plane = strip({{-1, 0}, {1, 0}});
  const ContactSet contacts = sphere_contacts(plane, {0.1, 0.2, -0.05}, 0.25, 0, 0);
  ASSERT_EQ(contacts.count, 1);
  EXPECT_NEAR(contacts.contacts[0].gap, -0.3, 1e-15);
  EXPECT_EQ(contacts.contacts[0].normal, Vec3(0, 0, 1));
}

TEST(SphereContacts, AreTheLocalMinimaOfTheDistanceOverTheWholeSurface) {
  // Brute force: a triangle's closest point is a minimum when no point of the surface near it is nearer.
  Sample s{std::mt19937_64(35)};
  int found = 0;
  for (const char* name : {"organ.off", "genus5.off", "torus.off", "slab_coarse.off"}) {
    const TestSurface surface = load_test_surface(name);
    const auto n = static_cast<int>(surface.patch.triangles.size());
    for (int i = 0; i < 60; ++i) {
      const Vec3 centre = point_near(s, surface, 0.01);
      if (winding_number(surface, centre) > 0.5) continue;
      const double radius = distance_to(surface, centre) + s.uniform(0, 0.003);
      std::vector<Vec3> minima;
      for (int t = 0; t < n; ++t) {
        const ClosestPoint at = closest_on(surface, t, centre);
        if (at.distance_sq > radius * radius) continue;
        bool is_minimum = true;
        for (int other = 0; is_minimum && other < n; ++other) {
          if (closest_on(surface, other, at.point).distance_sq > 1e-24) continue;  // does not hold the point
          is_minimum = closest_on(surface, other, centre).distance_sq > at.distance_sq * (1 - 1e-9);
        }
        const bool seen = winding_number(surface, at.point + 1e-6 * (centre - at.point).normalized()) < 0.5;
        const bool is_new = std::ranges::none_of(minima, [&](const Vec3& m) { return (m - at.point).norm() < 1e-9; });
        if (is_minimum && seen && is_new) minima.push_back(at.point);
      }
      const ContactSet contacts = sphere_contacts(surface, centre, radius);
      EXPECT_EQ(contacts.count, static_cast<int>(minima.size())) << name << " " << i;
      for (const Contact& c : contacts) {
        const Vec3 point = centre - (c.gap + radius) * c.normal;
        EXPECT_TRUE(std::ranges::any_of(minima, [&](const Vec3& m) { return (m - point).norm() < 1e-9; })) << name;
      }
      found += contacts.count;
    }
  }
  EXPECT_GT(found, 100);
}

TEST(ContactSet, KeepsTheDeepestWhenFull) {
  ContactSet set;
  for (int i = 0; i < 3 * kMaxContacts; ++i) {
    Contact c;
    c.gap = (i * 7) % (3 * kMaxContacts);
    set.add(c);
  }
  ASSERT_EQ(set.count, kMaxContacts);
  for (const Contact& c : set) EXPECT_LT(c.gap, kMaxContacts);
}

}  // namespace
}  // namespace kt
