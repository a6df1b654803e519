// Reports over a link that loses, repeats and disorders datagrams, in virtual time: the body is given each impulse
// once.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "haptics/remote/report_box.hpp"

namespace kt {
namespace {

constexpr double kH = 1e-3;

LocalReport random_report(int tick, std::mt19937& random) {
  std::uniform_real_distribution<double> any(-1, 1);
  LocalReport out;
  out.tick = tick;
  out.model_frame = tick / 33;
  out.tools[0].pose.x = Vec3(any(random), any(random), any(random));
  // Contact comes and goes.
  const int contacts = (tick / 40) % 3 == 1 ? 1 + static_cast<int>(random() % 3) : 0;
  for (int i = 0; i < contacts; ++i) {
    TickContact& c = out.samples[static_cast<std::size_t>(out.count++)];
    c.t = tick * kH;
    c.triangle = static_cast<int>(random() % 100);
    c.bary = Vec3(0.2, 0.3, 0.5);
    c.impulse = 1e-3 * Vec3(any(random), any(random), any(random));
    c.normal = Vec3::UnitZ();
    c.point = out.tools[0].pose.x;
    c.tool = static_cast<int>(random() % 2);
  }
  return out;
}

ImpulseCount sum_of(std::span<const LocalReport> reports, int tool) {
  ImpulseCount out{};
  for (const LocalReport& r : reports)
    for (const TickContact& c : r.contacts())
      for (std::size_t i = 0; i < 3; ++i)
        if (c.tool == tool) out[i] += count_impulse(c.impulse)[i];
  return out;
}

void try_seeds(int seeds) {
  constexpr int kTicks = 240, kEvery = 4;
  int gaps = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    std::mt19937 random(static_cast<unsigned>(seed));
    std::uniform_real_distribution<double> share(0, 1);
    const double loss = 0.5 * share(random), twice = 0.3 * share(random), late = 0.5 * share(random);
    ReportOutbox outbox(64, kH);
    ReportInbox inbox(kH);
    std::array<ImpulseCount, 2> given{};
    std::set<int> ticks;
    std::vector<std::pair<int, ReportBatch>> on_the_way;  // due, what
    for (int tick = 0; tick < kTicks; ++tick) {
      outbox.add(random_report(tick, random));
      if (tick % kEvery == kEvery - 1 && share(random) >= loss) {
        const int copies = share(random) < twice ? 2 : 1;
        for (int i = 0; i < copies; ++i)
          on_the_way.emplace_back(tick + (share(random) < late ? static_cast<int>(random() % 30) : 0),
                                  outbox.batch(4 * kEvery));
      }
      for (auto it = on_the_way.begin(); it != on_the_way.end();) {
        if (it->first > tick) {
          ++it;
          continue;
        }
        inbox.take(it->second);
        it = on_the_way.erase(it);
      }
      // A motion gets through now and then: the body goes on to there.
      if (random() % 40 != 0 && tick + 1 != kTicks) continue;
      const auto reports = inbox.close(outbox.batch(2));
      gaps += static_cast<int>(inbox.lost().size());
      for (const LocalReport& r : reports) {
        EXPECT_TRUE(ticks.insert(r.tick).second) << "tick " << r.tick << " twice, seed " << seed;
      }
      EXPECT_TRUE(std::ranges::is_sorted(reports, {}, &LocalReport::tick));
      for (int k = 0; k < 2; ++k) {
        const ImpulseCount more = sum_of(reports, k);
        for (std::size_t i = 0; i < 3; ++i) given[static_cast<std::size_t>(k)][i] += more[i];
      }
      ASSERT_EQ(given, outbox.sum()) << "seed " << seed << ", tick " << tick;
      EXPECT_EQ(inbox.next(), tick + 1);
    }
    // What comes after all is none of it.
    for (const auto& [due, batch] : on_the_way) inbox.take(batch);
    ASSERT_EQ(inbox.sum(), outbox.sum()) << "seed " << seed;
  }
  EXPECT_GT(gaps, seeds / 10);  // it was put to the test
}

TEST(ReportBox, WhateverTheLinkDoesTheBodyIsGivenEachImpulseOnceAndTheSumsAreEqual) { try_seeds(1000); }
TEST(ReportBox, SoItIsForTenThousandSeeds) { try_seeds(10000); }

TEST(ReportBox, WhatWasLostIsGivenAtTheLastPlaceThatIsKnown) {
  ReportOutbox outbox(64, kH);
  ReportInbox inbox(kH);
  const auto pressed = [](int tick, int triangle) {
    LocalReport r;
    r.tick = tick;
    r.model_frame = 7;
    r.count = 1;
    r.samples[0] = {.t = tick * kH,
                    .triangle = triangle,
                    .bary = Vec3(1, 0, 0),
                    .impulse = Vec3(0, 0, -1e-3),
                    .normal = Vec3::UnitZ()};
    return r;
  };
  outbox.add(pressed(0, 11));
  inbox.take(outbox.batch(1));
  for (int tick = 1; tick < 5; ++tick) outbox.add(pressed(tick, 20 + tick));  // lost
  LocalReport free;
  free.tick = 5;
  outbox.add(free);
  const auto reports = inbox.close(outbox.batch(1));
  EXPECT_EQ(inbox.lost(), (std::vector<int>{1, 2, 3, 4}));
  ASSERT_EQ(reports.size(), 3u);  // tick 0, what was lost, tick 5
  EXPECT_EQ(reports[1].tick, 1);
  ASSERT_EQ(reports[1].count, 1);
  EXPECT_EQ(reports[1].samples[0].triangle, 11);
  EXPECT_NEAR(reports[1].samples[0].impulse.z(), -4e-3, 4 * kImpulseQuantum);
  EXPECT_DOUBLE_EQ(reports[1].samples[0].t, 1 * kH);
}

TEST(ReportBox, ATouchThatWasLostFromItsFirstTickOnIsGivenWhereTheHandTells) {
  ReportOutbox outbox(64, kH);
  ReportInbox inbox(kH);
  LocalReport touch;
  touch.count = 1;
  touch.samples[0] = {.triangle = 42, .bary = Vec3(0, 1, 0), .impulse = Vec3(0, 0, -2e-3), .normal = Vec3::UnitZ()};
  outbox.add(touch);
  for (int tick = 1; tick < 4; ++tick) {
    LocalReport free;
    free.tick = tick;
    outbox.add(free);
  }
  const auto reports = inbox.close(outbox.batch(2));  // of ticks 2 and 3
  ASSERT_EQ(reports.size(), 3u);
  EXPECT_EQ(reports[0].samples[0].triangle, 42);
  EXPECT_EQ(inbox.sum(), outbox.sum());
}

TEST(ReportBox, AnAbsurdTickNeitherFillsTheMemoryNorEndsTheRun) {
  ReportInbox inbox(kH);
  ReportBatch far;
  far.reports.resize(1);
  far.reports[0].tick = 1 << 30;
  inbox.take(far);
  EXPECT_TRUE(inbox.close(far).empty());
  EXPECT_EQ(inbox.next(), 0);
  EXPECT_TRUE(inbox.lost().empty());
  ReportOutbox outbox(4, kH);
  outbox.add({});
  EXPECT_EQ(inbox.close(outbox.batch(1)).size(), 1u);
}

TEST(ReportBox, AsSentIsWhatItSays) {
  LocalReport r;
  r.tick = 3;
  r.count = 1;
  r.samples[0].impulse = Vec3(1.0 / 3, -1e-12, 5);
  r.samples[0].point = Vec3(0.1, 0.2, 0.3);
  r.tools[0].pose.x = Vec3(0.1, 0.2, 0.3);
  r.samples[0].bary = Vec3(0.1, 0.2, 0.7);
  r.samples[0].normal = Vec3(0.6, 0.1, 0.3);
  r.tools[0].pose.r = Quaternion(0.1, 0.2, 0.3, 0.4);
  const LocalReport sent = as_sent(r, kH);
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(sent.samples[0].bary[c], static_cast<double>(static_cast<float>(r.samples[0].bary[c]))) << c;
    EXPECT_EQ(sent.samples[0].normal[c], static_cast<double>(static_cast<float>(r.samples[0].normal[c]))) << c;
    EXPECT_EQ(sent.samples[0].point[c], static_cast<double>(static_cast<float>(r.samples[0].point[c]))) << c;
  }
  for (int c = 0; c < 4; ++c)
    EXPECT_EQ(sent.tools[0].pose.r.coeffs()[c], static_cast<double>(static_cast<float>(r.tools[0].pose.r.coeffs()[c])));
  EXPECT_NEAR(sent.samples[0].impulse.x(), 1.0 / 3, kImpulseQuantum);
  EXPECT_EQ(sent.samples[0].impulse.y(), 0);
  EXPECT_NEAR(sent.samples[0].impulse.z(), kMostImpulse, 2 * kImpulseQuantum);  // cut
  EXPECT_EQ(sent.samples[0].point.x(), static_cast<double>(0.1f));
  EXPECT_EQ(sent.tools[0].pose.x, r.tools[0].pose.x);
  const LocalReport again = as_sent(sent, kH);
  EXPECT_EQ(again.samples[0].impulse, sent.samples[0].impulse);
  EXPECT_EQ(again.samples[0].point, sent.samples[0].point);
}

}  // namespace
}  // namespace kt
