// Seals: the datagram's bytes against the library asked directly, replays and the edge of the window, measured loss.
#include <gtest/gtest.h>
#include <sodium.h>

#include <random>

#include "network/channel/sealed.hpp"

namespace kt {
namespace {

using Bytes = std::vector<std::uint8_t>;

const Bytes kPayload{'h', 'e', 'l', 'l', 'o'};

TEST(Sealed, DatagramByTheLibraryItself) {
  const SealKey key = new_seal_key();
  Sealer sealer(key, 7);
  Bytes datagram;
  for (int i = 0; i < 259; ++i) sealer.seal(kPayload, datagram);  // the last counter is 258 = 0x102
  ASSERT_EQ(datagram.size(), 8 + kPayload.size() + 16);
  EXPECT_EQ(Bytes(datagram.begin(), datagram.begin() + 8), (Bytes{2, 1, 0, 0, 0, 0, 0, 0}));
  const Bytes nonce{7, 0, 0, 0, 2, 1, 0, 0, 0, 0, 0, 0};
  Bytes opened(kPayload.size());
  ASSERT_EQ(crypto_aead_chacha20poly1305_ietf_decrypt(opened.data(), nullptr, nullptr, datagram.data() + 8,
                                                      datagram.size() - 8, nullptr, 0, nonce.data(), key.data()),
            0);
  EXPECT_EQ(opened, kPayload);
  EXPECT_EQ(sealer.num_sealed(), 259u);
  EXPECT_NE(new_seal_key(), new_seal_key());
}

TEST(Sealed, OnlyTheKeyAndTheDirectionOpen) {
  const SealKey key = new_seal_key();
  SealKey other = key;
  other[31] ^= 1;
  Sealer sealer(key, 0);
  Opener good(key, 0), wrong_key(other, 0), own_side(key, 1);
  Bytes datagram, payload{1, 2, 3};
  sealer.seal(kPayload, datagram);
  EXPECT_FALSE(wrong_key.open(datagram, payload));
  EXPECT_TRUE(payload.empty());
  EXPECT_FALSE(own_side.open(datagram, payload));
  EXPECT_EQ(wrong_key.counts().forged, 1);
  EXPECT_EQ(own_side.counts().forged, 1);
  EXPECT_TRUE(good.open(datagram, payload));
  EXPECT_EQ(payload, kPayload);
  sealer.seal({}, datagram);
  EXPECT_TRUE(good.open(datagram, payload));  // nothing is a payload, too
  EXPECT_TRUE(payload.empty());
  EXPECT_FALSE(good.open(Bytes(23), payload));
  EXPECT_FALSE(good.open(Bytes{}, payload));
  EXPECT_EQ(good.counts().too_short, 2);
  EXPECT_FALSE(good.open(Bytes(30, 0xff), payload));  // the largest counter
  EXPECT_EQ(good.counts().forged, 1);
  EXPECT_EQ(good.counts().refused(), 3);
}

std::vector<Bytes> sealed_ones(const SealKey& key, int count) {
  Sealer sealer(key, 0);
  std::vector<Bytes> out(static_cast<std::size_t>(count));
  for (Bytes& datagram : out) sealer.seal(kPayload, datagram);
  return out;
}

TEST(Sealed, ReplaysAreRefusedToTheEdgeOfTheWindow) {
  const SealKey key = new_seal_key();
  const auto sent = sealed_ones(key, 10001);
  Opener opener(key, 0);
  Bytes payload;
  EXPECT_TRUE(opener.open(sent[5000], payload));
  EXPECT_FALSE(opener.open(sent[5000], payload));
  EXPECT_EQ(opener.counts().replayed, 1);
  EXPECT_TRUE(opener.open(sent[5000 - 4095], payload));  // the oldest of the window, late
  EXPECT_FALSE(opener.open(sent[5000 - 4095], payload));
  EXPECT_FALSE(opener.open(sent[5000 - 4096], payload));
  EXPECT_EQ(opener.counts().too_old, 1);
  EXPECT_TRUE(opener.open(sent[4999], payload));
  EXPECT_TRUE(opener.open(sent[5000 + 4095], payload));  // 5000 is still in the window
  EXPECT_FALSE(opener.open(sent[5000], payload));
  EXPECT_EQ(opener.counts().replayed, 3);
  EXPECT_TRUE(opener.open(sent[5001], payload));  // shares its place in the ring with one that came
  EXPECT_TRUE(opener.open(sent[10000], payload));
  for (int i = 0; i < 10001; ++i) opener.open(sent[static_cast<std::size_t>(i)], payload);
  for (int i = 0; i < 10001; ++i) EXPECT_FALSE(opener.open(sent[static_cast<std::size_t>(i)], payload));
}

TEST(Sealed, AForgedCounterMovesNoWindow) {
  const SealKey key = new_seal_key();
  const auto sent = sealed_ones(key, 10);
  Opener opener(key, 0);
  Bytes payload, forged = sent[3];
  forged[6] = 0x7f;  // far in the future
  EXPECT_FALSE(opener.open(forged, payload));
  for (const Bytes& datagram : sent) EXPECT_TRUE(opener.open(datagram, payload));
}

TEST(Sealed, LossIsTheShareThatNeverCame) {
  const SealKey key = new_seal_key();
  const auto sent = sealed_ones(key, 2000);
  Opener opener(key, 0);
  Bytes payload;
  const auto open_all = [&](int from, int to, auto&& comes) {
    for (int i = from; i < to; ++i)
      if (comes(i)) opener.open(sent[static_cast<std::size_t>(i)], payload);
  };
  open_all(100, 291, [](int i) { return i % 4 != 0; });
  EXPECT_FALSE(opener.loss()) << "too few yet: 192 are needed, from the first that came";
  open_all(291, 1000, [](int i) { return i % 4 != 0; });
  EXPECT_DOUBLE_EQ(opener.loss().value(), 0.25);
  open_all(1000, 1576, [](int) { return true; });
  EXPECT_DOUBLE_EQ(opener.loss().value(), 0) << "what is older than 512 + 64 is forgotten";
  open_all(1576, 1640, [](int i) { return i == 1639; });
  EXPECT_DOUBLE_EQ(opener.loss().value(), 0) << "the last 64 may be on their way";
  open_all(1640, 1700, [](int) { return true; });
  EXPECT_DOUBLE_EQ(opener.loss().value(), 60 / 512.0);
  open_all(1576, 1639, [](int) { return true; });
  EXPECT_DOUBLE_EQ(opener.loss().value(), 0) << "late is not lost";
}

TEST(Sealed, LossFollowsThatOfARandomLine) {
  std::mt19937_64 random(5);
  const SealKey key = new_seal_key();
  const auto sent = sealed_ones(key, 20000);
  Opener opener(key, 0);
  Bytes payload;
  double sum = 0;
  int counted = 0;
  for (std::size_t i = 0; i + 8 < sent.size(); i += 8)
    for (std::size_t j : {3, 0, 7, 1, 2, 6, 5, 4}) {  // reordered
      if (std::uniform_real_distribution<double>(0, 1)(random) < 0.2) continue;
      opener.open(sent[i + j], payload);
      if (i < 1000) continue;
      sum += opener.loss().value();
      ++counted;
      EXPECT_NEAR(opener.loss().value(), 0.2, 0.08);  // 4.5 deviations of 512 draws
    }
  EXPECT_NEAR(sum / counted, 0.2, 0.01);
}

}  // namespace
}  // namespace kt
