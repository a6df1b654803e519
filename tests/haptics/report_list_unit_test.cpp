// The list of reports against a plain vector of ticks.
#include "haptics/touch/report_list.hpp"

#include <gtest/gtest.h>

#include <random>

#include "haptics/link/ring.hpp"

namespace kt {
namespace {

LocalReport report_of(int tick, int contacts) {
  LocalReport out;
  out.tick = tick;
  out.count = contacts;
  for (int i = 0; i < contacts; ++i) out.samples[static_cast<std::size_t>(i)].triangle = 100 * tick + i;
  return out;
}

TEST(ReportList, HoldsWhatAVectorWould) {
  std::mt19937 random(1);
  ReportList list(4);
  std::vector<int> truth;
  int tick = 0;
  for (int round = 0; round < 200; ++round) {
    const auto more = random() % 7, away = random() % (truth.size() + more + 1);
    for (unsigned i = 0; i < more; ++i, ++tick) {
      list.add(report_of(tick, tick % 3));
      truth.push_back(tick);
    }
    list.drop(away);
    truth.erase(truth.begin(), truth.begin() + static_cast<std::ptrdiff_t>(away));
    if (round % 50 == 49) {
      list.clear();
      truth.clear();
    }
    ASSERT_EQ(list.all().size(), truth.size());
    ASSERT_EQ(list.empty(), truth.empty());
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const LocalReport& r = list.all()[i];
      ASSERT_EQ(r.tick, truth[i]);
      ASSERT_EQ(r.count, truth[i] % 3);
      for (int c = 0; c < r.count; ++c)
        ASSERT_EQ(r.contacts()[static_cast<std::size_t>(c)].triangle, 100 * truth[i] + c);
    }
  }
}

TEST(ReportList, KeepsItsMemory) {
  ReportList list(8);
  for (int i = 0; i < 8; ++i) list.add(report_of(i, 0));
  const LocalReport* const first = list.all().data();
  for (int i = 0; i < 1000; ++i) {
    list.drop(3);
    for (int k = 0; k < 3; ++k) list.add(report_of(i, 1));
    ASSERT_EQ(list.all().data(), first);
  }
}

/// What is not kept after it was asked for does not count.
TEST(ReportList, ANextThatIsNotKeptIsNotThere) {
  Ring<LocalReport> ring(2);
  ReportList list(1);
  EXPECT_EQ(ring.size(), 0u);
  EXPECT_FALSE(ring.pop(list.next()));
  EXPECT_TRUE(list.empty());
  ring.push(report_of(5, 2));
  EXPECT_EQ(ring.size(), 1u);
  EXPECT_TRUE(ring.pop(list.next()));
  list.keep_next();
  ASSERT_EQ(list.all().size(), 1u);
  EXPECT_EQ(list.all()[0].tick, 5);
}

}  // namespace
}  // namespace kt
