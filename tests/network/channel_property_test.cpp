// Shards, parity and seals over lines that lose, double and reorder, in virtual time; and whatever else may arrive.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <set>

#include "network/channel/sealed.hpp"
#include "network/channel/shards.hpp"
#include "tests/network/channel_line.hpp"

namespace kt {
namespace {

constexpr std::uint8_t kModel = 0, kReport = 1 | kKeepAll;

Bytes content(std::uint8_t kind, std::uint32_t number, std::size_t size) {
  std::mt19937_64 random(number * 256 + kind);
  Bytes bytes(size);
  for (std::size_t i = 0; i < size; i += 8) {
    const std::uint64_t word = random();
    std::memcpy(&bytes[i], &word, std::min<std::size_t>(8, size - i));
  }
  return bytes;
}

/// One end of the line that receives.
struct Receiver {
  explicit Receiver(const SealKey& key) : opener(key, 0) {}
  std::optional<Message> take(const Bytes& datagram) {
    Bytes payload;
    if (!opener.open(datagram, payload)) return std::nullopt;
    return joiner.take(payload);
  }
  Opener opener;
  ShardJoiner joiner;
};

/// A model every 33 ms of sizes that change, a report every 4 ms, for a while. All that is asked of what arrives.
struct Travelled {
  long models_sent = 0, models = 0, reports_sent = 0, reports = 0;
  double loss = 0;  ///< measured at the end
};

Travelled travel(const LineOptions& line_options, std::uint64_t seed, int num_models, int least_shards,
                 int most_shards) {
  std::mt19937_64 random(seed);
  const SealKey key = new_seal_key();
  Sealer sealer(key, 0);
  Receiver receiver(key);
  VirtualLine line(line_options, seed + 1);
  Travelled out;
  std::map<std::uint32_t, std::size_t> sizes;
  std::optional<std::uint32_t> newest_model;
  std::set<std::uint32_t> seen_reports;
  const auto arrived = [&](const Bytes& datagram) {
    const auto message = receiver.take(datagram);
    if (!message) return;
    if (message->kind == kModel) {
      ASSERT_TRUE(!newest_model || message->number > *newest_model);  // once, and never an older one
      newest_model = message->number;
      ASSERT_EQ(message->bytes, content(kModel, message->number, sizes.at(message->number)));
      ++out.models;
    } else {
      ASSERT_EQ(message->kind, kReport);
      ASSERT_TRUE(seen_reports.insert(message->number).second);  // each once
      ASSERT_EQ(message->bytes, content(kReport, message->number, 1500));
      ++out.reports;
    }
  };
  double now = 0;
  const auto send = [&](const Message& message, double loss) {
    Bytes datagram;
    double at = now;
    int burst = 0;
    for (const Bytes& payload : split(message, loss)) {
      sealer.seal(payload, datagram);
      line.send(at, datagram);
      if (++burst % 8 == 0) at += 300e-6;
    }
  };
  const int num_steps = num_models * 8 + 40;
  for (int step = 0; step < num_steps; ++step, now += 4e-3) {
    if (step % 8 == 0 && step / 8 < num_models) {
      const auto number = static_cast<std::uint32_t>(step / 8);
      const int shards =
          least_shards + static_cast<int>(random() % static_cast<unsigned>(most_shards - least_shards + 1));
      sizes[number] = static_cast<std::size_t>(shards) * kShardContent - random() % 1000;
      send({kModel, number, content(kModel, number, sizes[number])}, line_options.loss);
      ++out.models_sent;
    }
    const auto report = static_cast<std::uint32_t>(step);
    send({kReport, report, content(kReport, report, 1500)}, -1);
    ++out.reports_sent;
    line.arrive(now, arrived);
    if (testing::Test::HasFatalFailure()) return out;
  }
  line.arrive(now + 1, arrived);
  out.loss = receiver.opener.loss().value_or(-1);
  return out;
}

TEST(ChannelProperty, NewestOnceAndEqualOverRandomLines) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::mt19937_64 random(seed);
    LineOptions line;
    line.loss = 0.4 * uniform(random);
    line.duplicate = 0.3 * uniform(random);
    line.delay = 0.2 * uniform(random);
    line.jitter = 0.1 * uniform(random) * uniform(random);
    const Travelled r = travel(line, seed, 20, 1, 120);
    ASSERT_FALSE(HasFatalFailure()) << "seed " << seed;
    EXPECT_GT(r.models, 0) << "seed " << seed;
    EXPECT_GT(r.reports, r.reports_sent / 5) << "seed " << seed;  // two shards, no parity: at 40 % a third or more
  }
}

TEST(ChannelProperty, ThatManyAreDecodedAtTheMeasuredLoss) {
  for (const double loss : {0.0, 0.1, 0.2, 0.4}) {
    LineOptions line;
    line.loss = loss;
    long sent = 0, got = 0;
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
      const Travelled r = travel(line, seed * 100, 50, 62, 206);
      ASSERT_FALSE(HasFatalFailure());
      sent += r.models_sent;
      got += r.models;
      EXPECT_NEAR(r.loss, loss, 0.1);  // 4.6 deviations of 512 draws at 40 %
    }
    EXPECT_GE(static_cast<double>(got), 0.99 * static_cast<double>(sent)) << "at " << loss;
  }
}

/// Changed copies of datagrams come before them.
void expect_no_forgery(int num_mutations) {
  constexpr int kRound = 500;  // then another receiver, who has opened none yet
  std::mt19937_64 random(11);
  const SealKey key = new_seal_key();
  Sealer sealer(key, 0);
  std::vector<Bytes> sent(256);
  const auto payload_of = [](std::size_t i) { return content(2, static_cast<std::uint32_t>(i), 1 + i * 37 % 200); };
  for (std::size_t i = 0; i < sent.size(); ++i) sealer.seal(payload_of(i), sent[i]);
  Bytes opened;
  long forged = 0, refused = 0, accepted = 0;
  for (int round = 0; round < num_mutations / kRound; ++round) {
    Opener opener(key, 0);
    for (int i = 0; i < kRound; ++i) {
      const Bytes wrong = mutated(sent[random() % sent.size()], sent[random() % sent.size()], random);
      if (!opener.open(wrong, opened)) continue;
      const auto same = std::find(sent.begin(), sent.end(), wrong);  // a change may change nothing
      ASSERT_NE(same, sent.end()) << "accepted what was never sent";
      ASSERT_EQ(opened, payload_of(static_cast<std::size_t>(same - sent.begin())));
    }
    for (const Bytes& datagram : sent) opener.open(datagram, opened);
    accepted += opener.counts().opened;
    forged += opener.counts().forged;
    refused += opener.counts().refused();
  }
  EXPECT_EQ(accepted, num_mutations / kRound * static_cast<long>(sent.size()));  // each once, and nothing else
  EXPECT_EQ(refused, num_mutations);
  EXPECT_GT(forged, num_mutations / 2);
}

/// Changed payloads, as if the seals were none: nothing breaks, and memory stays bounded.
void expect_no_harm(int num_mutations) {
  constexpr int kRound = 1000;  // then another receiver: numbers that were made up are the newest soon
  std::mt19937_64 random(12);
  std::vector<Bytes> pool;
  for (std::uint8_t kind : {std::uint8_t{0}, std::uint8_t{5}, std::uint8_t{1 | kKeepAll}})
    for (std::uint32_t number : {0U, 1U, 7U, 300U})
      for (const std::size_t size : {0, 30, 1500, 9000})
        for (Bytes& p : split({kind, number, content(kind, number, size)}, 0.1)) pool.push_back(std::move(p));
  JoinerCounts sum;
  for (int round = 0; round < num_mutations / kRound; ++round) {
    ShardJoiner joiner;
    std::map<std::uint8_t, std::uint32_t> newest;
    for (int i = 0; i < kRound; ++i) {
      const auto message = joiner.take(mutated(pool[random() % pool.size()], pool[random() % pool.size()], random));
      ASSERT_LE(joiner.held_bytes(), ShardJoiner::kMostHeldBytes);
      if (!message || message->kind & kKeepAll) continue;
      const auto found = newest.find(message->kind);
      ASSERT_TRUE(found == newest.end() || message->number > found->second);
      newest[message->kind] = message->number;
    }
    const JoinerCounts c = joiner.counts();
    EXPECT_EQ(c.payloads, kRound);
    sum.malformed += c.malformed;
    sum.disagreeing += c.disagreeing;
    sum.repeated += c.repeated;
    sum.old += c.old;
    sum.messages += c.messages;
    sum.given_up += c.given_up;
  }
  EXPECT_GT(sum.malformed, num_mutations / 4);
  for (const long count : {sum.disagreeing, sum.repeated, sum.old, sum.messages, sum.given_up})
    EXPECT_GT(count, num_mutations / 1000);
}

TEST(ChannelMutations, NoForgeryIsOpened) { expect_no_forgery(100000); }
TEST(ChannelMutations, NoPayloadDoesHarm) { expect_no_harm(100000); }
TEST(ChannelMutations, MillionNoForgeryIsOpened) { expect_no_forgery(1000000); }
TEST(ChannelMutations, MillionNoPayloadDoesHarm) { expect_no_harm(1000000); }

}  // namespace
}  // namespace kt
