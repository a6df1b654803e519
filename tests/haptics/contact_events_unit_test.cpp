#include "haptics/session/contact_events.hpp"

#include <gtest/gtest.h>

namespace kt {
namespace {

LocalFrame frame(double t, ContactMode mode, int triangle) {
  LocalFrame f;
  f.t = t;
  f.mode = mode;
  f.triangle = triangle;
  f.point = Vec3(t, 0, 0);
  f.force = Vec3(0, t, 0);
  f.f_n = 2 * t;
  return f;
}

TEST(ContactEvents, AreChangesOfContactModeAndTriangle) {
  using Mode = ContactMode;
  const std::vector<LocalFrame> frames = {frame(1, Mode::free, -1),
                                          frame(2, Mode::stick, 4),
                                          frame(3, Mode::stick, 4),
                                          frame(4, Mode::frictional_slide, 7),
                                          frame(5, Mode::frictional_slide, 7),
                                          frame(6, Mode::stick, 7),
                                          frame(7, Mode::free, -1)};
  const std::vector<ContactEvent> found = find_contact_events(frames);
  ASSERT_EQ(found.size(), 5U);
  using Kind = ContactEventKind;
  const Kind kinds[] = {Kind::touch, Kind::stick_to_slip, Kind::edge, Kind::slip_to_stick, Kind::release};
  const double times[] = {2, 4, 4, 6, 7};
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(found[i].kind, kinds[i]) << i;
    EXPECT_EQ(found[i].t, times[i]) << i;
  }
  EXPECT_EQ(found[0].triangle_before, -1);
  EXPECT_EQ(found[2].triangle_before, 4);
  EXPECT_EQ(found[2].triangle, 7);
  EXPECT_EQ(found[4].triangle, -1);
  EXPECT_EQ(found[4].place, Vec3(6, 0, 0));  // where it was last
  EXPECT_EQ(found[4].f_n, 12);
}

TEST(ContactEvents, OfNothingAreNone) {
  EXPECT_TRUE(find_contact_events({}).empty());
  EXPECT_TRUE(find_contact_events(std::vector<LocalFrame>(3)).empty());
}

}  // namespace
}  // namespace kt
