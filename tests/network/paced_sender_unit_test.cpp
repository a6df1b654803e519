// Pace in a time of its own.
#include <gtest/gtest.h>

#include "network/channel/paced_sender.hpp"

namespace kt {
namespace {

using std::chrono::microseconds;
using Payloads = std::vector<std::vector<std::uint8_t>>;

Payloads payloads(int count, std::uint8_t name) {
  Payloads out;
  for (int i = 0; i < count; ++i) out.push_back({name, static_cast<std::uint8_t>(i)});
  return out;
}

struct Line {
  PacedSender sender;
  PacedSender::Time now{std::chrono::hours(1)};
  std::vector<std::pair<int, int>> sent;  ///< name and place in the message
  std::optional<microseconds> pump() {
    return sender.pump(now, [&](std::span<const std::uint8_t> p) { sent.emplace_back(p[0], p[1]); });
  }
};

TEST(PacedSender, EightEach300Microseconds) {
  Line line;
  EXPECT_FALSE(line.pump());
  line.sender.put(payloads(20, 1), false);
  EXPECT_EQ(line.pump(), microseconds(300));
  EXPECT_EQ(line.sent.size(), 8u);
  line.now += microseconds(100);
  EXPECT_EQ(line.pump(), microseconds(200));
  EXPECT_EQ(line.sent.size(), 8u);
  line.now += microseconds(200);
  EXPECT_EQ(line.pump(), microseconds(300));
  EXPECT_EQ(line.sent.size(), 16u);
  line.now += microseconds(300);
  EXPECT_FALSE(line.pump());
  ASSERT_EQ(line.sent.size(), 20u);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(line.sent[static_cast<std::size_t>(i)], std::pair(1, i));
  line.sender.put(payloads(8, 2), false);  // too soon after the last
  EXPECT_EQ(line.pump(), microseconds(300));
  EXPECT_EQ(line.sent.size(), 20u);
}

TEST(PacedSender, ANewerMessageReplacesTheRestOfItsKind) {
  Line line;
  line.sender.put(payloads(20, 1), false);
  line.pump();
  line.sender.put(payloads(4, 2), false);
  line.sender.put(payloads(3, 9), false, 5);
  EXPECT_EQ(line.sender.num_waiting(), 7u);
  line.now += microseconds(300);
  EXPECT_FALSE(line.pump());
  EXPECT_EQ(line.sent.size(), 8u + 4u + 3u);
  EXPECT_EQ(line.sent[8], std::pair(2, 0));
  EXPECT_EQ(line.sent[12], std::pair(9, 0));
  EXPECT_EQ(line.sender.counts().replaced, 12);
  EXPECT_EQ(line.sender.counts().paced, 15);
}

TEST(PacedSender, UrgentOnesGoFirstAndAtOnce) {
  Line line;
  line.sender.put(payloads(20, 1), false);
  line.pump();
  line.sender.put(payloads(2, 7), true);
  line.sender.put(payloads(1, 8), true);
  EXPECT_EQ(line.pump(), microseconds(300));
  ASSERT_EQ(line.sent.size(), 11u);
  EXPECT_EQ(line.sent[8], std::pair(7, 0));
  EXPECT_EQ(line.sent[9], std::pair(7, 1));
  EXPECT_EQ(line.sent[10], std::pair(8, 0));
  line.sender.put(payloads(250, 1), true);
  for (int i = 0; i < 4; ++i) line.sender.put(payloads(250, 1), true);
  EXPECT_EQ(line.sender.counts().overflown, 1250 - 1024);
}

TEST(PacedSender, ALatePumpMakesUpForAFewIntervals) {
  Line line;
  line.sender.put(payloads(200, 1), false);
  line.pump();
  line.now += microseconds(900);  // three bursts are due
  line.pump();
  EXPECT_EQ(line.sent.size(), 8u * 4);
  line.now += std::chrono::seconds(1);  // five at most
  line.pump();
  EXPECT_EQ(line.sent.size(), 8u * 9);
  Line idle;
  idle.pump();
  idle.now += std::chrono::seconds(1);
  idle.sender.put(payloads(200, 1), false);
  idle.pump();
  EXPECT_EQ(idle.sent.size(), 8u) << "time without anything to send is not made up for";
}

}  // namespace
}  // namespace kt
