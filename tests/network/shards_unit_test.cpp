// Shards by hand: the header's bytes, sizes at the edges, which messages are given out, and what is refused.
#include <gtest/gtest.h>

#include <stdexcept>

#include "network/channel/shards.hpp"

namespace kt {
namespace {

using Bytes = std::vector<std::uint8_t>;

Message message_of(std::uint8_t kind, std::uint32_t number, std::size_t size) {
  Message m{kind, number, Bytes(size)};
  for (std::size_t i = 0; i < size; ++i) m.bytes[i] = static_cast<std::uint8_t>(i * 31 + number * 7 + kind);
  return m;
}

std::optional<Message> take_all(ShardJoiner& joiner, const std::vector<Bytes>& payloads) {
  std::optional<Message> out;
  for (const Bytes& p : payloads)
    if (auto one = joiner.take(p)) out = std::move(one);
  return out;
}

TEST(Shards, HeaderByHand) {
  const auto payloads = split(message_of(3, 0x01020304, 3000), -1);
  ASSERT_EQ(payloads.size(), 3u);
  const Bytes header(payloads[2].begin(), payloads[2].begin() + 16);
  EXPECT_EQ(header, (Bytes{3, 1, 3, 0, 0, 0, 2, 0, 4, 3, 2, 1, 0xb8, 0x0b, 0, 0}));
  for (const Bytes& p : payloads) EXPECT_EQ(p.size(), 16u + 1000u);
  EXPECT_EQ(payloads[1][16], static_cast<std::uint8_t>(1000 * 31 + 0x01020304 * 7 + 3));
}

TEST(Shards, SizesAtTheEdges) {
  for (const std::size_t size : {0, 1, 2, 1151, 1152, 1153, 2304, 2305, 74000, 2 << 20})
    for (const double loss : {-1.0, 0.0, 0.2}) {
      ShardJoiner joiner;
      const Message sent = message_of(1, 9, size);
      const auto payloads = split(sent, loss);
      EXPECT_EQ(payloads.size() > std::max<std::size_t>(1, (size + 1151) / 1152), loss >= 0);
      for (const Bytes& p : payloads) ASSERT_LE(p.size(), kShardBytes);
      const auto got = take_all(joiner, payloads);
      ASSERT_TRUE(got) << size;
      EXPECT_EQ(got->kind, 1);
      EXPECT_EQ(got->number, 9u);
      EXPECT_EQ(got->bytes, sent.bytes);
      EXPECT_EQ(joiner.held_bytes(), 0u);
      EXPECT_EQ(joiner.counts().messages, 1);
    }
  EXPECT_THROW(split(message_of(1, 0, (2 << 20) + 1), 0), std::invalid_argument);
  EXPECT_THROW(split(message_of(16, 0, 1), 0), std::invalid_argument);
}

TEST(Shards, ParityMakesUpForLostOnes) {
  ShardJoiner joiner;
  const Message sent = message_of(0, 1, 62 * 1152);
  auto payloads = split(sent, 0.2);
  ASSERT_EQ(payloads.size(), 62u + 34u);
  payloads.erase(payloads.begin() + 5, payloads.begin() + 5 + 34);
  const auto got = take_all(joiner, payloads);
  ASSERT_TRUE(got);
  EXPECT_EQ(got->bytes, sent.bytes);
  EXPECT_EQ(joiner.counts().recovered, 1);
}

TEST(Shards, TheNewestOfAKindWins) {
  ShardJoiner joiner;
  const auto first = split(message_of(0, 1, 4000), -1), second = split(message_of(0, 2, 4000), -1),
             other = split(message_of(1, 1, 10), -1);
  EXPECT_FALSE(joiner.take(first[0]));
  EXPECT_EQ(take_all(joiner, second)->number, 2u);
  EXPECT_EQ(joiner.counts().given_up, 1);
  EXPECT_FALSE(take_all(joiner, first));
  EXPECT_FALSE(take_all(joiner, second));
  EXPECT_EQ(joiner.counts().old, static_cast<long>(first.size() + second.size()));
  EXPECT_EQ(take_all(joiner, other)->kind, 1);  // kinds do not know each other
  EXPECT_EQ(joiner.held_bytes(), 0u);
}

TEST(Shards, AnOlderOneMayComeFirst) {
  ShardJoiner joiner;
  const auto first = split(message_of(0, 1, 4000), -1), second = split(message_of(0, 2, 4000), -1);
  EXPECT_FALSE(joiner.take(second[0]));
  EXPECT_EQ(take_all(joiner, first)->number, 1u);
  EXPECT_EQ(take_all(joiner, second)->number, 2u);
}

TEST(Shards, KeptKindsComeOnceInAnyOrder) {
  ShardJoiner joiner;
  const auto report = [](std::uint32_t number) { return split(message_of(kKeepAll | 2, number, 1500), -1); };
  EXPECT_EQ(take_all(joiner, report(5))->number, 5u);
  EXPECT_EQ(take_all(joiner, report(3))->number, 3u);
  EXPECT_FALSE(take_all(joiner, report(3)));
  EXPECT_EQ(take_all(joiner, report(5 + 4095))->number, 5u + 4095u);
  EXPECT_FALSE(take_all(joiner, report(5)));
  EXPECT_EQ(take_all(joiner, report(6))->number, 6u);  // 4094 behind: still in the window
  EXPECT_EQ(take_all(joiner, report(5 + 4096))->number, 5u + 4096u);
  EXPECT_FALSE(take_all(joiner, report(4)));  // out of the window: cannot tell, though it never came
  EXPECT_EQ(take_all(joiner, report(7))->number, 7u);
  EXPECT_EQ(take_all(joiner, report(1000000))->number, 1000000u);
  EXPECT_EQ(take_all(joiner, report(999999))->number, 999999u);
  EXPECT_FALSE(take_all(joiner, report(5 + 4096)));
  EXPECT_EQ(take_all(joiner, report(1000000 + 4097))->number, 1000000u + 4097u);
  EXPECT_EQ(take_all(joiner, report(1000000 + 4096))->number, 1000000u + 4096u) << "shares its place with 1000000";
}

TEST(Shards, FourIncompleteOnesOfAKindAreHeld) {
  ShardJoiner joiner;
  std::vector<std::vector<Bytes>> sent;
  for (std::uint32_t number = 0; number < 6; ++number) sent.push_back(split(message_of(0, number, 2000), -1));
  for (const std::size_t number : {1, 2, 3, 4}) EXPECT_FALSE(joiner.take(sent[number][0]));
  EXPECT_FALSE(joiner.take(sent[0][0]));  // older than all of them
  EXPECT_EQ(joiner.counts().old, 1);
  EXPECT_FALSE(joiner.take(sent[5][0]));
  EXPECT_EQ(joiner.counts().given_up, 1);
  EXPECT_FALSE(joiner.take(sent[1][1]));  // its first half is gone
  EXPECT_EQ(joiner.take(sent[2][1])->number, 2u);
  EXPECT_EQ(joiner.take(sent[5][1])->number, 5u);
  EXPECT_EQ(joiner.held_bytes(), 0u);
}

TEST(Shards, RepeatedAndSurplusOnesAreCounted) {
  ShardJoiner joiner;
  const auto payloads = split(message_of(0, 1, 200 * 1152), 0.1);  // two blocks of 100
  for (std::size_t i = 0; i < 200; i += 2) EXPECT_FALSE(joiner.take(payloads[i]));
  EXPECT_FALSE(joiner.take(payloads[0]));
  EXPECT_EQ(joiner.counts().repeated, 1);
  EXPECT_FALSE(joiner.take(payloads[200]));  // parity of the block that has all its data
  EXPECT_EQ(joiner.counts().surplus, 1);
}

TEST(Shards, WhatDisagreesWithTheFirstIsRefused) {
  const auto payloads = split(message_of(0, 1, 4000), 0.1);
  for (const auto& [byte, value] : {std::pair{4, 9}, std::pair{12, 0xa1}}) {  // parity shards; total by one
    ShardJoiner joiner;
    joiner.take(payloads[0]);
    Bytes wrong = payloads[1];
    wrong[static_cast<std::size_t>(byte)] = static_cast<std::uint8_t>(value);
    EXPECT_FALSE(joiner.take(wrong));
    EXPECT_EQ(joiner.counts().disagreeing + joiner.counts().malformed, 1) << byte;
    EXPECT_EQ(take_all(joiner, payloads)->bytes, message_of(0, 1, 4000).bytes);
  }
}

TEST(Shards, MalformedHeadersAreRefused) {
  const Bytes good = split(message_of(2, 7, 1500), 0.1)[0];  // 2 data shards of 750
  const auto changed = [&](std::size_t at, int value) {
    Bytes b = good;
    b[at] = static_cast<std::uint8_t>(value);
    return b;
  };
  Bytes longer = good, shorter = good, huge = good;
  longer.push_back(0);
  shorter.pop_back();
  huge[14] = 0x21;  // more than 2 MiB
  Bytes past_the_end = good, three_small = Bytes(good.begin(), good.begin() + 16 + 500), many_small(16 + 1);
  past_the_end[6] = static_cast<std::uint8_t>(good[2] + good[4]);
  three_small[2] = 3;  // agree with each other, but nobody splits so
  many_small[1] = 1;
  many_small[2] = many_small[3] = many_small[12] = many_small[13] = 0xff;
  const std::vector<Bytes> wrong{{},
                                 past_the_end,
                                 three_small,
                                 many_small,
                                 Bytes(good.begin(), good.begin() + 15),
                                 Bytes(good.begin(), good.begin() + 16),
                                 longer,
                                 shorter,
                                 huge,
                                 changed(0, 16),
                                 changed(0, 0x7f),
                                 changed(1, 0),
                                 changed(1, 2),
                                 changed(2, 0),
                                 changed(2, 1),
                                 changed(2, 3),
                                 changed(3, 1),
                                 changed(5, 200),
                                 changed(6, 200),
                                 changed(7, 255),
                                 changed(12, 0),
                                 changed(13, 0xff)};
  ShardJoiner joiner;
  for (std::size_t i = 0; i < wrong.size(); ++i) {
    EXPECT_FALSE(joiner.take(wrong[i])) << i;
    EXPECT_EQ(joiner.counts().malformed, static_cast<long>(i) + 1) << i;
  }
  EXPECT_EQ(joiner.held_bytes(), 0u);
}

TEST(Shards, MemoryIsBounded) {
  ShardJoiner joiner;
  auto payloads = split(message_of(0, 0, 2 << 20), -1);
  payloads.resize(payloads.size() / 2);
  for (std::uint8_t number = 0; number < 6; ++number)
    for (std::uint8_t kind = 0; kind < kNumKinds; ++kind)  // half of each: 96 MiB
      for (Bytes& p : payloads) {
        p[0] = kind;
        p[8] = number;
        EXPECT_FALSE(joiner.take(p));
        ASSERT_LE(joiner.held_bytes(), ShardJoiner::kMostHeldBytes);
      }
  const JoinerCounts counts = joiner.counts();
  EXPECT_GE(counts.given_up, 64);  // at most four of a kind
  const Message last = message_of(3, 100, 2 << 20);
  EXPECT_EQ(take_all(joiner, split(last, -1))->bytes, last.bytes);  // and it goes on
  EXPECT_LE(joiner.held_bytes(), ShardJoiner::kMostHeldBytes);
}

}  // namespace
}  // namespace kt
