// Settings that are changed faster than the body is refreshed: the last values count, and a rate that was set too low
// can be set right.
#include <gtest/gtest.h>

#include <chrono>
#include <random>
#include <thread>

#include "core/body/mesh.hpp"
#include "haptics/halves/live_settings.hpp"
#include "haptics/halves/model_observer.hpp"
#include "haptics/session/session.hpp"
#include "haptics/touch/touch.hpp"
#include "haptics/touch/touch_halves.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

struct Taken final : ModelObserver {
  std::vector<SettingChange> changes;
  std::size_t most = 0;  // of one refresh
  void refreshed(const RefreshRecord& record) override {
    most = std::max(most, record.settings.size());
    changes.insert(changes.end(), record.settings.begin(), record.settings.end());
  }
};

Pose pose_of(const Session& session, int tick) { return {interpolate_path(session.paths()[0].points, tick * 1e-3)}; }

class LiveChanges : public ::testing::Test {
 protected:
  Pose pose(int tick) const { return pose_of(session_, tick); }
  /// Forces of a drag in lockstep; `change` is called in the 60th tick.
  std::vector<Vec3> forces(const std::function<void(Touch&)>& change, Taken& taken) const {
    Touch touch(session_.body(), session_.options());
    TouchHalves::observe(touch, &taken);
    touch.place(pose(0));
    std::vector<Vec3> out;
    for (int i = 0; i < 120; ++i) {
      if (i == 60) change(touch);
      out.push_back(touch.tick(pose(i + 1)).force);
    }
    touch.stop();
    return out;
  }

  Session session_{small_scene()};
};

TEST_F(LiveChanges, TheLastValueCounts) {
  Taken many, once;
  const auto stormed = forces(
      [](Touch& touch) {
        for (int i = 0; i < 500; ++i) {
          touch.set("object.model.young", 5000 + 10 * i);
          touch.set("tool.radius", 0.004 + 1e-6 * i);
          touch.set("local.reducer", i % 2 == 0 ? "krylov" : "condensed");
        }
      },
      many);
  const auto calm = forces(
      [](Touch& touch) {
        touch.set("object.model.young", 9990);
        touch.set("tool.radius", 0.004 + 499e-6);
        touch.set("local.reducer", "condensed");
      },
      once);
  EXPECT_EQ(stormed, calm);  // bit for bit
  EXPECT_EQ(many.changes.size(), 3u);
  EXPECT_EQ(once.changes.size(), 3u);
}

// A scene may give a point the radius 0; a tool that has one keeps it above that.
TEST_F(LiveChanges, ARadiusStaysAboveZero) {
  Taken none;
  forces([](Touch& touch) { EXPECT_THROW(touch.set("tool.radius", 0), InputError); }, none);
  EXPECT_TRUE(none.changes.empty());
}

// The friction coefficients move one another, and only some orders of them are allowed.
TEST_F(LiveChanges, FrictionComesToWhatItWasSetTo) {
  std::mt19937 random(1);
  for (int round = 0; round < 2; ++round) {
    double mu_static = 0, mu_kinetic = 0;
    Taken many, once;
    const auto stormed = forces(
        [&](Touch& touch) {
          for (int i = 0; i < 60; ++i) {
            const double value = 1e-3 * static_cast<double>(random() % 1000);
            const auto kind = random() % 3;
            if (kind == 2)
              touch.set("contact.mu_kinetic", value * touch.number("contact.mu_static"));
            else
              touch.set(kind == 0 ? "contact.mu" : "contact.mu_static", value);
          }
          mu_static = touch.number("contact.mu_static");
          mu_kinetic = touch.number("contact.mu_kinetic");
        },
        many);
    const auto calm = forces(
        [&](Touch& touch) {
          touch.set("contact.mu", mu_static);
          touch.set("contact.mu_kinetic", mu_kinetic);
        },
        once);
    EXPECT_EQ(stormed, calm) << mu_static << ' ' << mu_kinetic;
    EXPECT_LE(many.most, live_settings().size());
  }
}

/// At 0.01 Hz a tool could come anywhere before the next refresh: the patch is the whole surface, and a refresh takes
/// seconds of a body of 935 nodes.
class RateOfASmallBody : public ::testing::Test {
 protected:
  Pose pose(int tick) const { return pose_of(session_, tick); }
  Session session_{small_scene(), kuhn_block(4, 4, 2, 0.015)};
};

TEST_F(RateOfASmallBody, ThatWasTooLowIsSetRight) {
  Touch touch(session_.body(), session_.options());
  touch.place(pose(0));
  int tick = 0;
  const auto ticks = [&](int count) {
    for (int i = 0; i < count; ++i) touch.tick(pose(++tick % 2));  // in the air: no refresh comes early
    return touch.status().refreshes;
  };
  touch.set("global.rate_hz", 0.01);
  ticks(20);
  const int before = ticks(60);
  EXPECT_EQ(ticks(60), before);
  touch.set("global.rate_hz", 50);
  EXPECT_GE(ticks(100), before + 4);
}

// The same with the body in a thread of its own.
TEST_F(RateOfASmallBody, ThatWasTooLowIsSetRightInThreads) {
  Touch touch(session_.body(), session_.options());
  touch.place(pose(0));
  touch.start();
  int tick = 0;
  const auto tick_until = [&](const std::function<bool()>& done) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(100);
    while (!done() && std::chrono::steady_clock::now() < end) {
      touch.tick(pose(++tick % 2));
      std::this_thread::sleep_for(std::chrono::microseconds(500));
    }
    return done();
  };
  touch.set("global.rate_hz", 0.001);
  const int first = touch.status().refreshes;  // none before the first tick
  ASSERT_TRUE(tick_until([&] { return touch.status().refreshes > first; }));
  touch.set("global.rate_hz", 50);
  const int before = touch.status().refreshes;
  EXPECT_TRUE(tick_until([&] { return touch.status().refreshes >= before + 3; }));
  touch.stop();
}

}  // namespace
}  // namespace kt
