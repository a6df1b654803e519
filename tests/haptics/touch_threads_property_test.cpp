// A loop of one's own against the wall clock, the body in its thread: nothing waits, nothing is allocated, contact
// stays when the body does not follow.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

#include "core/body/wrapping_model.hpp"
#include "haptics/halves/body_side.hpp"
#include "haptics/halves/haptic_side.hpp"
#include "haptics/session/session.hpp"
#include "haptics/touch/touch.hpp"
#include "haptics/touch/touch_halves.hpp"
#include "haptics/watch/contact_watch.hpp"
#include "tests/support/allocations.hpp"
#include "tests/support/haptics_scene.hpp"
#include "tests/support/held_up_model.hpp"

namespace kt {
namespace {

using namespace std::chrono_literals;

class TouchThreads : public testing::Test {
 protected:
  void SetUp() override {
    scene_ = small_scene();
    scene_.duration = 1;
    scene_.contact.surface = "loop";  // no steps of the mesh's own, at its edges
    session_.emplace(scene_);
  }
  Pose pose(double t) const { return {interpolate_path(session_->path(), t)}; }
  Scene scene_;
  std::optional<Session> session_;
};

/// Held up for so many ticks and no longer: beside other programs the hand stands still until there is a new local
/// model.
TEST_F(TouchThreads, ContactStaysWhileTheBodyIsHeldUp) {
  constexpr int kPressed = 150, kHeld = 250, kOfAModel = 70;  // along the path
  constexpr double kBrakes = 0.1;                             // of its speed, in a tick
  for (const int held_ms : {100, 500}) {
    auto slow = std::make_unique<HeldUpModel>(session_->model());
    HeldUpModel& model = *slow;
    const Body body(std::move(slow));
    Touch touch(body, session_->options());
    ContactWatch watch(body.surface(), session_->tools(), true);
    TouchHalves::observe(touch, &watch);
    touch.place(pose(0));
    touch.start();
    double before = 0, sum = 0, most_step = 0;
    int pressed = 0, stale = 0, off = 0, tick = 0;
    auto due = std::chrono::steady_clock::now();
    int i = 0, came = 0, refreshes = 0;  // along the path; since the last refresh
    double at = 0, speed = 1;            // along the path: the tool waits for a model, and brakes before
    for (; i < 1000 && tick < 60'000; ++tick) {
      model.is_held = i >= kHeld && i < kHeld + held_ms;
      const int made = touch.status().refreshes;
      if (made != refreshes) came = 0;
      refreshes = made;
      speed += std::clamp((model.is_held || came++ < kOfAModel ? 1 : 0) - speed, -kBrakes, kBrakes);
      at += speed;
      i = static_cast<int>(at);
      due = std::max(due + 1ms, std::chrono::steady_clock::now());
      std::this_thread::sleep_until(due);
      const LocalFrame& f = touch.tick(pose(at * 1e-3));
      watch.ticked(TouchHalves::fast(touch), {&f, 1});
      const double force = f.force.norm();
      if (i > kPressed) {
        most_step = std::max(most_step, std::abs(force - before));
        sum += force;
        off += force == 0;
        ++pressed;
      }
      stale += (f.flags & kStaleModel) != 0;
      before = force;
    }
    model.is_held = false;
    touch.stop();
    ASSERT_EQ(i, 1000) << touch.status().error;
    watch.finish(TouchHalves::fast(touch).model());
    EXPECT_EQ(off, 0) << held_ms;
    EXPECT_EQ(watch.lost(0).free_ticks_inside, 0) << held_ms;
    EXPECT_LT(most_step, 0.1 * sum / pressed) << held_ms;
    if (held_ms == 500) {
      EXPECT_GT(stale, 200);
    }
  }
}

TEST_F(TouchThreads, ATickAllocatesNothing) {
  Touch touch(session_->body(), session_->options());
  touch.place(pose(0));
  touch.start();
  long long allocations = 0;
  for (int i = 0; i < 400 || (i < 5000 && touch.status().refreshes < 5); ++i) {
    std::this_thread::sleep_for(500us);
    const Pose next = pose((i + 1) * 1e-3);
    allocations += allocations_during([&] { touch.tick(next); });
  }
  touch.stop();
#ifdef __SANITIZE_THREAD__
  constexpr int kFew = 1;  // the body is ten times slower
#else
  constexpr int kFew = 3;
#endif
  EXPECT_EQ(allocations, 0);
  EXPECT_GT(touch.status().refreshes, kFew);
}

/// What the sanitizer of threads looks at: settings, positions and status from other threads while ticks go on.
TEST_F(TouchThreads, OthersMayLookAndChangeWhileItTicks) {
  Touch touch(session_->body(), session_->options());
  struct Changes final : ModelObserver {
    std::size_t count = 0;
    int refreshes = 0;
    void refreshed(const RefreshRecord& r) override {
      count += r.settings.size();
      ++refreshes;
    }
  } told;
  TouchHalves::observe(touch, &told);
  touch.place(pose(0));
  touch.start();
  std::atomic<bool> stop{false};
  std::thread looks([&] {
    VectorX x;
    while (!stop) {
      touch.copy_positions(x);
      ASSERT_TRUE(x.allFinite());
      ASSERT_TRUE(touch.status().error.empty());
      std::this_thread::sleep_for(5ms);
    }
  });
  std::thread changes([&] {
    for (int i = 0; !stop; ++i) {
      touch.set("contact.mu", 0.2 + 0.1 * (i % 5));
      touch.set("tool.radius", 0.004 + 1e-5 * (i % 10));
      if (i % 5 == 4) touch.set("object.model.young", 1e4 + 1e3 * (i % 3));
      if (i % 7 == 6) touch.set("global.rate_hz", 25 + i % 10);
      std::this_thread::sleep_for(20ms);
    }
  });
  bool finite = true;
  for (int i = 0; i < 600; ++i) {
    std::this_thread::sleep_for(800us);
    finite = finite && touch.tick(pose((i + 1) * 1e-3)).force.allFinite();
  }
  stop = true;
  looks.join();
  changes.join();
  touch.stop();
  EXPECT_TRUE(finite);
  EXPECT_GT(told.count, 0u);  // of a setting the last value of each refresh: a busy machine has few
  EXPECT_EQ(told.refreshes, touch.status().refreshes);
}

/// A model that fails while it is touched.
struct Breaks final : WrappingModel {
  using WrappingModel::WrappingModel;
  void force(const State& s, VectorX& out) const override {
    if (s.t > 0.2) throw RunError("the model gave up");
    model_.force(s, out);
  }
};

/// Follows which settings the refreshes took.
struct TakenSettings final : ModelObserver {
  void refreshed(const RefreshRecord& record) override {
    for (const SettingChange& change : record.settings) taken.push_back(change);
  }
  std::vector<SettingChange> taken;
};

TEST_F(TouchThreads, WhatIsSetBeforeTheStartHolds) {
  TakenSettings settings;
  Touch touch(session_->body(), session_->options());
  TouchHalves::observe(touch, &settings);
  touch.place(pose(0));
  touch.set("contact.mu", 0.9);
  touch.start();
  EXPECT_EQ(touch.number("contact.mu"), 0.9);
  for (int i = 0; i < 3; ++i) touch.tick(pose(0));
  touch.stop();
  ASSERT_EQ(settings.taken.size(), 1u);
  EXPECT_EQ(settings.taken[0], (SettingChange{0, "contact.mu", 0.9, ""}));
}

TEST_F(TouchThreads, ABodyThatFailsIsToldAndTheLastModelGoesOn) {
  for (const bool in_thread : {false, true}) {
    const Body body(std::make_unique<Breaks>(session_->model()));
    Touch touch(body, session_->options());
    touch.place(pose(0));
    if (in_thread) touch.start();
    LocalFrame last;
    auto due = std::chrono::steady_clock::now();
    for (int i = 0; i < 500 || (i < 20000 && !touch.error()); ++i) {  // on a busy machine the body comes later
      if (in_thread) std::this_thread::sleep_until(due += 1ms);
      touch.tick(pose((i + 1) * 1e-3));
    }
    last = touch.tick(pose(1));
    EXPECT_NE(last.flags & kBodyFailed, 0u);
    EXPECT_TRUE(last.force.allFinite());
    EXPECT_GT(last.force.norm(), 0);
    EXPECT_EQ(touch.status().error, "the model gave up");
    EXPECT_THROW(touch.stop(), RunError);
  }
}

}  // namespace
}  // namespace kt
