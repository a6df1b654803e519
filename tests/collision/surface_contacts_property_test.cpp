// A tool that is dragged about is never lost: tracking over neighbours stays on the surface it touches.
#include <gtest/gtest.h>

#include <random>

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

}  // namespace
}  // namespace kt
