// A tool that is dragged about is never lost: tracking over neighbours stays on the surface it touches.
#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "collision/held/chosen_places.hpp"
#include "collision/held/vertex_contacts.hpp"
#include "tests/support/allocations.hpp"
#include "tests/support/collision_surfaces.hpp"
#include "tests/support/random_sample.hpp"

namespace kt {
namespace {

/// Drags a point along the surface for `steps` ticks at random speeds up to 0.5 m/s, between `deepest` [m] inside and
/// 2 mm outside, and compares what is tracked with the nearest point of the whole surface in every tick.
void drag(const char* name, double deepest, unsigned seed, int steps) {
  Sample s{std::mt19937_64(seed)};
  const TestSurface surface = load_test_surface(name);
  Vec3 p = node(surface.x, static_cast<int>(s.random() % static_cast<std::size_t>(surface.x.size() / 3)));
  Contact contact = nearest_point_contact(surface.patch, surface.x, p);
  Vec3 way = s.cube();
  double height = 0;
  for (int i = 0; i < steps; ++i) {
    way = (way + 0.3 * s.cube()).normalized();
    height = std::clamp(height + 1e-4 * s.uniform(-1, 1), -deepest, 2e-3);
    const Vec3 normal = contact.normal;
    const Vec3 tangential = way - way.dot(normal) * normal;
    p += 5e-4 * s.uniform(0, 1) * tangential + (height - contact.gap) * normal;
    contact = track_point_contact(surface.patch, surface.x, p, contact.triangle);
    ASSERT_NEAR(std::abs(contact.gap), distance_to(surface, p), 1e-15) << name << " seed " << seed << " tick " << i;
    ASSERT_NEAR(contact.normal.norm(), 1, 1e-14);
    if (i % 50 == 0 && std::abs(contact.gap) > 1e-9) {
      ASSERT_EQ(contact.gap > 0, winding_number(surface, p) < 0.5);
    }
  }
}

TEST(Drag, TrackingNeverLosesTheSurface) {
  for (unsigned seed = 1; seed <= 10; ++seed)
    for (const char* name : {"sphere.off", "torus.off", "organ.off"}) drag(name, 2e-3, seed, 500);
}

TEST(Drag, ContactFindingNeedsNoMemory) {
  const TestSurface surface = load_test_surface("sphere.off");
  const Vec3 p(0.001, 0.002, 0.0295);
  const std::vector<int> candidates = {0, 1, 2, 3};
  ContactSet contacts;
  const int start = nearest_point_contact(surface.patch, surface.x, p).triangle;
  double sum = 0;
  EXPECT_EQ(allocations_during([&] {
              sum += nearest_point_contact(surface.patch, surface.x, p).gap;
              sum += track_point_contact(surface.patch, surface.x, p, start).gap;
              find_sphere_contacts(surface.patch, surface.x, p, 0.001, 1e-4, candidates, start, contacts);
            }),
            0);
  EXPECT_LT(sum, 0);
}

/// A dish of triangles that a ball of 0.1 m lies in: more places than there is room for.
TestSurface dish(int cells, double size, double radius) {
  Mesh mesh;
  mesh.x.resize(3 * (cells + 1) * (cells + 1));
  for (int i = 0; i <= cells; ++i)
    for (int k = 0; k <= cells; ++k) {
      const double x = size * (i - 0.5 * cells) / cells, y = size * (k - 0.5 * cells) / cells;
      node(mesh.x, i * (cells + 1) + k) = Vec3(x, y, radius - std::sqrt(radius * radius - x * x - y * y));
    }
  for (int i = 0; i < cells; ++i)
    for (int k = 0; k < cells; ++k) {
      const int a = i * (cells + 1) + k, b = a + cells + 1;
      mesh.triangles.push_back({a, b, b + 1});
      mesh.triangles.push_back({a, b + 1, a + 1});
    }
  return make_test_surface(std::move(mesh.triangles), std::move(mesh.x));
}

TEST(SphereContacts, MorePlacesThanRoomAreChosenApartAndStayChosen) {
  constexpr double kRadius = 0.1, kSize = 0.03;
  const TestSurface surface = dish(12, kSize, kRadius);
  std::vector<int> all(surface.patch.triangles.size());
  std::iota(all.begin(), all.end(), 0);
  const auto find = [&](const Vec3& centre) {
    ContactSet out;
    find_sphere_contacts(surface.patch, surface.x, centre, kRadius, 3e-4, all, -1, out);
    return out;
  };
  const ContactSet set = find({0, 0, kRadius});
  EXPECT_TRUE(are_chosen(set));
  EXPECT_GE(set.count, kMaxContacts / 3);
  EXPECT_LT(set.count, kMaxContacts);
  const auto place = [](const Contact& c) { return Vec3(c.core - (kRadius + c.gap) * c.normal); };
  double farthest = 0;  // from the nearest place, over the dish
  for (int v = 0; v < surface.patch.num_vertices(); ++v) {
    double nearest = 1;
    for (const Contact& c : set) nearest = std::min(nearest, (place(c) - node(surface.x, v)).norm());
    farthest = std::max(farthest, nearest);
  }
  EXPECT_LT(farthest, 0.35 * kSize);
  // A little deeper and a little aside: most are the same ones.
  const ContactSet next = find({1e-5, 2e-5, kRadius - 1e-5});
  int same = 0;
  for (const Contact& c : next)
    same += std::any_of(set.begin(), set.end(), [&](const Contact& o) { return (place(o) - place(c)).norm() < 1e-3; });
  EXPECT_GE(same, next.count / 2) << next.count;
  ContactSet few;  // what there is room for stays as it is
  find_sphere_contacts(surface.patch, surface.x, {0, 0, kRadius}, kRadius, 3e-4, std::span(all).first(20), -1, few);
  EXPECT_FALSE(are_chosen(few));
}

TEST(VertexContacts, MoreThanRoomAreChosenApartAndStayTheSameAllTheTick) {
  constexpr double kRadius = 0.1, kSize = 0.03;
  constexpr int kRoom = 30;
  const TestSurface surface = dish(12, kSize, kRadius);
  const auto vertices = static_cast<std::size_t>(surface.patch.num_vertices());
  std::vector<int> all(surface.patch.triangles.size());
  std::iota(all.begin(), all.end(), 0);
  std::vector<char> is_seen(vertices, 0);
  ChosenVertices chosen{false, std::vector<char>(vertices, 0)};
  const auto find = [&](const Vec3& centre, int room) {
    ContactSet out;
    const std::array corner{centre};
    add_vertex_contacts(surface.patch, surface.x, surface.x, {corner, {}, {}}, kRadius, 3e-4, all, {}, room, is_seen,
                        chosen, out);
    return out;
  };
  const auto place = [](const Contact& c) { return Vec3(c.core - (kRadius + c.gap) * c.normal); };
  ContactSet set;
  EXPECT_EQ(allocations_during([&] { set = find({0, 0, kRadius}, kRoom); }), 0);
  EXPECT_TRUE(chosen.is_made);
  EXPECT_LE(set.count, kRoom);
  EXPECT_GE(set.count, kRoom / 3);
  for (int i = 0; i < set.count; ++i)
    for (int k = 0; k < i; ++k) EXPECT_GT((place(set.contacts[i]) - place(set.contacts[k])).norm(), 0.1 * kSize);
  // Moved aside: none but those.
  const ContactSet next = find({1e-4, 2e-4, kRadius - 1e-5}, kRoom);
  EXPECT_GE(next.count, set.count - 2);
  for (const Contact& c : next)
    EXPECT_TRUE(std::any_of(set.begin(), set.end(),
                            [&](const Contact& o) { return o.triangle == c.triangle && o.bary == c.bary; }));
  chosen.is_made = false;
  EXPECT_GT(find({0, 0, kRadius}, 1).count, 0);
}

}  // namespace
}  // namespace kt
