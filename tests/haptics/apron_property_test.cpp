// A tool that gets off the patch before the next local model is there: the apron reaches the whole surface of a body of
// any size, says so in the frame, is found within a tick without memory, and is about as soft as the body.
#include <gtest/gtest.h>

#include <cmath>

#include "collision/shape/closest_point.hpp"
#include "haptics/halves/haptic_side.hpp"
#include "haptics/setup/session_parts.hpp"
#include "haptics/tick/body_check.hpp"
#include "haptics/touch/touch.hpp"
#include "tests/support/allocations.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

constexpr double kPlateCell = 0.004, kPlateThick = 0.008;  // [m]
constexpr int kPlateLong = 32, kPlateWide = 14;            // cells

/// 128 x 56 x 8 mm, glued below: 2,160 triangles, more than a window holds.
Body make_plate() {
  BodyOptions options;
  options.object.fixed.below = FixedBelow{"z", 0.01};
  options.object.model.type = "fem";
  options.object.model.material = "linear";
  options.backend = "brute_force";
  return Body(kuhn_block(kPlateLong, kPlateWide, static_cast<int>(kPlateThick / kPlateCell), kPlateCell), options);
}

TouchOptions late_options(double rate_hz) {
  TouchOptions options;
  options.tools[0].shape = {ToolShape::Kind::sphere, 0.004};
  options.global.rate_hz = rate_hz;
  options.global.early_refresh = false;
  options.local.reducer = "condensed";
  options.local.refine = "off";  // the apron's cells are as they are
  options.contact.mu_static = options.contact.mu_kinetic = 0;
  options.collision.backend = "brute_force";
  options.stale_s = 10;
  return options;
}

constexpr double kPressedIn = 0.0015;
/// The tool's centre when it is pressed in.
Vec3 pressed_at(double x) { return {x, 0.025, kPlateThick + 0.004 - kPressedIn}; }

/// Pressed for 0.2 s, then along at 0.25 m/s; a frame a tick.
std::vector<LocalFrame> drag_over(Touch& touch, double from, double to) {
  std::vector<LocalFrame> out;
  touch.place(Pose{pressed_at(from) + Vec3(0, 0, kPressedIn + 1e-3)});
  for (int i = 0; i < 200; ++i)
    out.push_back(touch.tick(Pose{pressed_at(from) + Vec3(0, 0, (kPressedIn + 1e-3) * std::max(0.0, 1 - i / 100.0))}));
  const double way = to - from;
  const int ticks = static_cast<int>(std::abs(way) / 2.5e-4);
  for (int i = 1; i <= ticks; ++i) out.push_back(touch.tick(Pose{pressed_at(from + way * i / ticks)}));
  return out;
}

TEST(Apron, ReachesTheWholeSurfaceOfALargeBodyAndTells) {
  const Body body = make_plate();
  ASSERT_GT(body.surface().triangles.size(), ApronWindow::kTriangles + 300u);
  Touch touch(body, late_options(1));
  const std::vector<LocalFrame> frames = drag_over(touch, 0.015, 0.11);
  int free = 0, flagged = 0;
  for (std::size_t i = 200; i < frames.size(); ++i) {
    free += frames[i].mode == ContactMode::free;
    flagged += (frames[i].flags & kOnApron) != 0;
  }
  EXPECT_EQ(free, 0) << "contact was lost";
  EXPECT_GT(flagged, 150) << "nothing tempted it";
  const std::vector<std::string> warnings = lines(touch.findings());
  EXPECT_TRUE(
      std::ranges::any_of(warnings, [](const std::string& w) { return w.find("outside the local model") < w.size(); }));
}

/// Against a touch that has sixty local models a second: on the patch, across its rim and beyond.
TEST(Apron, GivesAboutTheForceOfTheBody) {
  const Body body = make_plate();
  Touch late(body, late_options(1)), fresh(body, late_options(60));
  const std::vector<LocalFrame> apron = drag_over(late, 0.03, 0.1), truth = drag_over(fresh, 0.03, 0.1);
  double least = 1e9, most = 0;
  int on_apron = 0;
  for (std::size_t i = 200; i < apron.size(); ++i) {
    on_apron += (apron[i].flags & kOnApron) != 0;
    const double ratio = apron[i].f_n / truth[i].f_n;
    least = std::min(least, ratio);
    most = std::max(most, ratio);
  }
  EXPECT_GT(on_apron, 80) << "nothing tempted it";
  EXPECT_GT(least, 0.9);
  EXPECT_LT(most, 1.5);
}

/// Pinched from both sides and lifted: without the load it would fall as a whole. The apron must not fall ahead of it,
/// or a finger meets the underside there, and pushes harder, and it falls further (1e55 N within 50 ms).
TEST(Apron, StaysWithAFlapThatIsLifted) {
  BodyOptions options;
  options.object.fixed.below = FixedBelow{"x", 0.02};
  options.object.model.type = "fem";
  options.object.model.material = "neo_hookean";
  options.object.model.young = 2e4;
  options.object.model.poisson = 0.4;
  options.object.model.damping = {5, 2e-3};
  options.backend = "brute_force";
  const Body body(kuhn_block(16, 10, 4, 0.005), options);
  TouchOptions touched = late_options(30);
  touched.tools[0].shape.radius = 0.006;
  touched.tools.push_back(touched.tools[0]);
  touched.contact.mu_static = 0.6;
  touched.contact.mu_kinetic = 0.5;
  Touch touch(body, touched);
  const auto pinched = [](double pressed, double lifted) {
    const double half = 0.018 - pressed;  // 10 mm of the flap, 6 mm of a finger, 2 mm of air
    return std::array{Pose{Vec3(0.062, 0.026, 0.01 + lifted + half)}, Pose{Vec3(0.062, 0.026, 0.01 + lifted - half)}};
  };
  touch.place(pinched(0, 0));
  double most = 0;
  int at_edge = 0;
  for (int i = 0; i < 450; ++i) {
    const auto at = pinched(0.005 * std::min(1.0, i / 250.0), 0.02 * 1e-3 * std::max(0, i - 350));
    for (const LocalFrame& frame : touch.tick(at)) {
      most = std::max(most, frame.f_n);
      at_edge += (frame.flags & (kLeftPatch | kOnApron)) != 0;
    }
  }
  EXPECT_GT(most, 0.5);
  EXPECT_LT(most, 2);
  EXPECT_EQ(at_edge, 0);
}

TEST(Apron, IsMovedWithinATickWithoutMemory) {
  const Body body = make_plate();
  Touch touch(body, late_options(1));
  drag_over(touch, 0.015, 0.03);
  EXPECT_EQ(allocations_during([&] {
              for (int i = 1; i <= 300; ++i) touch.tick(Pose{pressed_at(0.03 + 2.5e-4 * i)});
            }),
            0);
  EXPECT_LT(touch.next_tick(), 1000) << "a refresh was among them";
}

/// The gap is told in free air, too: as none.
TEST(Frame, HasNoGapInFreeAir) {
  const Body body = make_plate();
  Touch touch(body, late_options(30));
  const LocalFrame frame = touch.tick(Pose{Vec3(0.05, 0.025, 0.05)});
  EXPECT_EQ(frame.mode, ContactMode::free);
  EXPECT_TRUE(std::isinf(frame.gap));
}

TEST(Touch, StartsAnewAfterReset) {
  const Body body = make_plate();
  Touch touch(body, late_options(30));
  touch.set("contact.mu", 0.3);
  const std::vector<LocalFrame> first = drag_over(touch, 0.03, 0.05);
  touch.reset();
  EXPECT_EQ(touch.next_tick(), 0);
  EXPECT_EQ(touch.number("contact.mu"), 0.3);
  const std::vector<LocalFrame> again = drag_over(touch, 0.03, 0.05);
  ASSERT_EQ(first.size(), again.size());
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_EQ(first[i].force, again[i].force) << i;
}

TEST(Touch, TakesAnEndlessStepAndGoesOn) {
  const Body body = make_plate();
  Touch touch(body, late_options(30));
  touch.place(Pose{pressed_at(0.05)});
  EXPECT_TRUE(touch.tick(Pose{pressed_at(0.05)}, 1e308).flags & kLateTick);
  const int tick = touch.next_tick();
  for (int i = 0; i < 10; ++i) touch.tick(Pose{pressed_at(0.05)}, 1e-3);
  EXPECT_NEAR(touch.next_tick() - tick, 10, 1);
}

TEST(Touch, RefusesNumbersThatCannotBe) {
  const Body body = make_plate();
  const auto refused = [&](auto change) {
    TouchOptions options = late_options(30);
    change(options);
    EXPECT_THROW(Touch(body, options), InputError);
  };
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  for (const double wrong : {-1.0, 0.0, nan, inf, 1e300}) {
    refused([&](TouchOptions& o) { o.tools[0].shape.radius = wrong; });
    refused([&](TouchOptions& o) { o.global.rate_hz = wrong; });
    refused([&](TouchOptions& o) { o.local.rate_hz = wrong; });
    refused([&](TouchOptions& o) { o.local.tolerance = wrong; });
  }
  refused([&](TouchOptions& o) { o.contact.mu_static = -0.1; });
  refused([&](TouchOptions& o) { o.link.loss = 2; });
  refused([&](TouchOptions& o) { o.tools[0].max_speed = nan; });
  BodyOptions wrong;
  wrong.object.model.young = -5;
  EXPECT_THROW(Body(kuhn_block(2, 2, 2, kPlateCell), wrong), InputError);
}

/// Springs and elements, whichever way round the tetrahedra are given.
TEST(Body, TurnsTetrahedraThatAreGivenTheOtherWay) {
  for (const char* type : {"msd", "fem"}) {
    BodyOptions options;
    options.object.model.type = type;
    options.object.fixed.below = FixedBelow{"z", 0.01};
    Mesh mesh = kuhn_block(8, 8, 4, kPlateCell), turned = mesh;
    for (Tetrahedron& t : turned.tetrahedra) std::swap(t[2], t[3]);
    for (Triangle& t : turned.triangles) std::swap(t[1], t[2]);
    const Body right(mesh, options), other(turned, options);
    Touch a(right, late_options(30)), b(other, late_options(30));
    double sum = 0;
    for (int i = 0; i <= 120; ++i) {
      const Pose at{Vec3(0.01, 0.01, kPlateThick + 0.004 - 1e-5 * i)};
      const double f = a.tick(at).f_n;
      EXPECT_NEAR(b.tick(at).f_n, f, 1e-6 * (1 + f)) << type << " " << i;
      sum += f;
    }
    EXPECT_GT(sum, 0);
    EXPECT_FALSE(other.findings().empty());
  }
}

}  // namespace
}  // namespace kt
