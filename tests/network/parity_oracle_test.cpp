// Parity against arithmetic of its own: GF(256) by long multiplication, every pattern of losses of small codes, chances
// by adding shard after shard.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "network/channel/parity.hpp"

namespace kt {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Product in GF(256) with x^8 + x^4 + x^3 + x^2 + 1, bit by bit.
std::uint8_t slow_product(std::uint8_t a, std::uint8_t b) {
  unsigned product = 0, shifted = a;
  for (unsigned bit = 0; bit < 8; ++bit) {
    if (b >> bit & 1) product ^= shifted;
    shifted = shifted << 1 ^ (shifted & 0x80 ? 0x11dU : 0U);
  }
  return static_cast<std::uint8_t>(product);
}

std::uint8_t slow_inverse(std::uint8_t a) {
  for (unsigned b = 1; b < 256; ++b)
    if (slow_product(a, static_cast<std::uint8_t>(b)) == 1) return static_cast<std::uint8_t>(b);
  return 0;
}

Bytes random_bytes(std::size_t size, std::mt19937_64& random) {
  Bytes bytes(size);
  for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(random());
  return bytes;
}

/// Data and parity shards in one row.
Bytes all_shards(const Bytes& data, int num_data, int num_parity, std::size_t bytes) {
  Bytes all = data;
  const Bytes parity = encode_parity(data, num_data, num_parity, bytes);
  all.insert(all.end(), parity.begin(), parity.end());
  return all;
}

std::vector<ArrivedShard> arrived(const Bytes& all, const std::vector<int>& indices, std::size_t bytes) {
  std::vector<ArrivedShard> out;
  for (const int i : indices) out.push_back({i, all.data() + static_cast<std::size_t>(i) * bytes});
  return out;
}

/// Chance that at least `least` of n shards arrive: the distribution of the number, one shard after the other.
double slow_enough(int n, int least, double loss) {
  std::vector<double> chance{1.0};
  for (int i = 0; i < n; ++i) {
    chance.push_back(0);
    for (std::size_t c = chance.size() - 1; c > 0; --c) chance[c] = chance[c] * loss + chance[c - 1] * (1 - loss);
    chance[0] *= loss;
  }
  double sum = 0;
  for (std::size_t c = static_cast<std::size_t>(least); c < chance.size(); ++c) sum += chance[c];
  return sum;
}

double slow_undecoded(int data, int parity, double loss) {
  const int blocks = (data + 127) / 128;
  double decoded = 1;
  for (int b = 0; b < blocks; ++b) {
    int k = 0, m = 0;
    for (int i = 0; i < data; ++i) k += i % blocks == b;
    for (int i = 0; i < parity; ++i) m += i % blocks == b;
    decoded *= slow_enough(k + m, k, loss);
  }
  return 1 - decoded;
}

TEST(Parity, IsACauchyMatrixTimesTheData) {
  std::mt19937_64 random(1);
  constexpr int kData = 150, kParity = 21;  // two blocks of 75, with 11 and 10 parity shards
  constexpr std::size_t kBytes = 3;
  const Bytes data = random_bytes(kData * kBytes, random), parity = encode_parity(data, kData, kParity, kBytes);
  ASSERT_EQ(parity.size(), kParity * kBytes);
  for (int p = 0; p < kParity; ++p)
    for (std::size_t byte = 0; byte < kBytes; ++byte) {
      std::uint8_t sum = 0;
      for (int i = 0; i < 75; ++i) {
        const int entry = (75 + p / 2) ^ i, shard = 2 * i + p % 2;
        sum ^= slow_product(slow_inverse(static_cast<std::uint8_t>(entry)),
                            data[static_cast<std::size_t>(shard) * kBytes + byte]);
      }
      ASSERT_EQ(parity[static_cast<std::size_t>(p) * kBytes + byte], sum) << p;
    }
}

TEST(Parity, EveryPatternOfLossesOfSmallCodes) {
  std::mt19937_64 random(2);
  long decoded = 0, undecoded = 0;
  for (int k = 1; k <= 6; ++k)
    for (int m = 0; m <= 5; ++m)
      for (const std::size_t bytes : {std::size_t{1}, std::size_t{37}, std::size_t{100}}) {
        const Bytes data = random_bytes(static_cast<std::size_t>(k) * bytes, random),
                    all = all_shards(data, k, m, bytes);
        for (unsigned pattern = 0; pattern < 1U << (k + m); ++pattern) {
          std::vector<int> indices;
          for (int i = 0; i < k + m; ++i)
            if (pattern >> i & 1) indices.push_back(i);
          Bytes out(data.size(), 0xee);
          const bool enough = static_cast<int>(indices.size()) >= k;
          ASSERT_EQ(decode_parity(arrived(all, indices, bytes), k, m, bytes, out), enough)
              << k << " " << m << " " << pattern;
          if (enough) {
            ASSERT_EQ(out, data) << k << " + " << m << ", arrived " << pattern;
          }
          ++(enough ? decoded : undecoded);
        }
      }
  EXPECT_GT(decoded, 9000);
  EXPECT_GT(undecoded, 1000);
}

TEST(Parity, RandomLossesOfLargeCodes) {
  std::mt19937_64 random(3);
  struct Code {
    int data, parity;
  };
  for (const Code code : {Code{62, 34}, Code{128, 127}, Code{1, 254}, Code{129, 70}, Code{206, 113}, Code{1821, 600}}) {
    constexpr std::size_t kBytes = 65;
    const Bytes data = random_bytes(static_cast<std::size_t>(code.data) * kBytes, random);
    const Bytes all = all_shards(data, code.data, code.parity, kBytes);
    const int blocks = (code.data + 127) / 128;
    for (int trial = 0; trial < (code.data > 1000 ? 2 : 12); ++trial) {
      std::vector<int> order, use;
      for (int i = 0; i < code.data + code.parity; ++i) order.push_back(i);
      std::shuffle(order.begin(), order.end(), random);
      std::vector<int> missing(static_cast<std::size_t>(blocks));  // just as many as each block needs
      for (int i = 0; i < code.data; ++i) ++missing[static_cast<std::size_t>(i % blocks)];
      for (const int i : order) {
        int& still = missing[static_cast<std::size_t>((i < code.data ? i : i - code.data) % blocks)];
        if (still > 0) use.push_back(i);
        still -= still > 0;
      }
      Bytes out(data.size());
      ASSERT_TRUE(decode_parity(arrived(all, use, kBytes), code.data, code.parity, kBytes, out));
      ASSERT_EQ(out, data) << code.data << " + " << code.parity;
      use.pop_back();
      ASSERT_FALSE(decode_parity(arrived(all, use, kBytes), code.data, code.parity, kBytes, out));
    }
  }
}

TEST(Parity, ChanceOfAMessageThatDoesNotArrive) {
  constexpr double kRoundoff = 1e-9;  // of the truth, which is 1 - a number next to 1
  for (const int data : {1, 2, 7, 62, 128, 129, 206, 300})
    for (const double loss : {0.0, 0.02, 0.12, 0.22, 0.42, 0.52, 1.0})
      for (const int parity : {0, 1, 5, 40, 110})
        EXPECT_NEAR(undecoded_probability(data, parity, loss), slow_undecoded(data, parity, loss), kRoundoff)
            << data << " + " << parity << " at " << loss;
  EXPECT_NEAR(undecoded_probability(1, 1, 0.1), 0.01, 1e-15);  // both lost
  EXPECT_NEAR(undecoded_probability(2, 0, 0.1), 0.19, 1e-15);
}

TEST(Parity, IsTheLeastThatIsEnough) {
  for (const int data : {1, 3, 62, 128, 129, 206, 700})
    for (const double loss : {0.0, 0.05, 0.1, 0.2, 0.4}) {
      const int parity = parity_shards(data, loss);
      ASSERT_GT(parity, 0);
      if (parity < most_parity_shards(data)) {
        EXPECT_LE(slow_undecoded(data, parity, loss + 0.02), 1e-3 + 1e-12) << data << " at " << loss;
      } else {  // no more fit
        EXPECT_EQ(data, 128);
        EXPECT_EQ(loss, 0.4);
        EXPECT_NEAR(slow_undecoded(data, parity, loss + 0.02), 5e-3, 1e-3);
      }
      EXPECT_GT(slow_undecoded(data, parity - 1, loss + 0.02), 1e-3) << data << " at " << loss;
    }
}

/// A hand that has measured nothing yet has not told that nothing is lost.
TEST(Parity, IsForALossThatIsKnownAndElseForSome) {
  EXPECT_EQ(loss_for_parity(0.1, 0.3), 0.1);
  EXPECT_EQ(loss_for_parity(0.0, 0.3), 0.0);
  EXPECT_EQ(loss_for_parity({}, 0.3), 0.3);
  EXPECT_EQ(loss_for_parity({}, {}), kLossUntilKnown);
  EXPECT_GT(parity_shards(60, loss_for_parity({}, {})), 2 * parity_shards(60, 0));
}

TEST(Parity, SharesOfTheDesign) {  // 10 % without loss, 32 % at 10 %, 55 % at 20 %: a message of 62 shards
  EXPECT_EQ(parity_shards(62, 0), 6);
  EXPECT_EQ(parity_shards(62, 0.1), 20);
  EXPECT_EQ(parity_shards(62, 0.2), 34);
  EXPECT_EQ(parity_shards(206, 0.2), 103);  // 50 %: a longer message needs less
}

TEST(Parity, FitsIntoBlocks) {
  EXPECT_EQ(num_blocks(0), 0);
  EXPECT_EQ(num_blocks(128), 1);
  EXPECT_EQ(num_blocks(129), 2);
  EXPECT_EQ(most_parity_shards(0), 0);
  EXPECT_EQ(most_parity_shards(1), 254);
  EXPECT_EQ(most_parity_shards(128), 127);
  EXPECT_EQ(most_parity_shards(129), 2 * (255 - 65));
  for (const int data : {1, 62, 128, 129, 256, 257, 1821})
    for (const double loss : {0.5, 1.0}) {
      const int parity = parity_shards(data, loss), blocks = num_blocks(data);
      EXPECT_LE(parity, most_parity_shards(data));
      for (int b = 0; b < blocks; ++b)
        EXPECT_LE(shards_in_block(data, blocks, b) + shards_in_block(parity, blocks, b), 255);
    }
  EXPECT_EQ(parity_shards(128, 1.0), 127);                    // no more fit
  EXPECT_EQ(parity_shards(62, 1.0), parity_shards(62, 0.5));  // nothing follows a line that is cut
}

}  // namespace
}  // namespace kt
