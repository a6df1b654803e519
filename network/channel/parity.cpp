#include "network/channel/parity.hpp"

#include <isa-l/erasure_code.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/error.hpp"

namespace kt {
namespace {

/// log(i!), i = 0 .. kMostBlockShards.
const std::array<double, kMostBlockShards + 1>& log_factorials() {
  static const auto table = [] {
    std::array<double, kMostBlockShards + 1> t{};
    for (std::size_t i = 1; i < t.size(); ++i) t[i] = t[i - 1] + std::log(static_cast<double>(i));
    return t;
  }();
  return table;
}

/// Probability that of `data` + `parity` shards more than `parity` are lost: the sum of the binomial's upper tail.
double block_undecoded(int data, int parity, double loss) {
  const int n = data + parity;
  if (data == 0 || loss <= 0) return 0;
  if (loss >= 1) return 1;
  const auto& log_f = log_factorials();
  const int first = parity + 1;
  double term =
      std::exp(log_f[static_cast<std::size_t>(n)] - log_f[static_cast<std::size_t>(first)] -
               log_f[static_cast<std::size_t>(n - first)] + first * std::log(loss) + (n - first) * std::log1p(-loss));
  double sum = 0;
  for (int lost = first; lost <= n; ++lost) {
    sum += term;
    term *= (n - lost) / (lost + 1.0) * loss / (1 - loss);
  }
  return std::min(sum, 1.0);
}

/// How parity shard j of a block of k data shards depends on data shard i: 1 / ((k + j) + i) in GF(256), where + is
/// exclusive or. A Cauchy matrix, as k + j and i are never equal.
std::uint8_t cauchy(int k, int j, int i) { return gf_inv(static_cast<std::uint8_t>((k + j) ^ i)); }

/// out[r] = sum over s of matrix(r, s) · in[s], byte by byte in GF(256).
void multiply(std::vector<std::uint8_t>& matrix, std::vector<const std::uint8_t*>& in, std::vector<std::uint8_t*>& out,
              std::size_t bytes) {
  if (out.empty() || in.empty() || bytes == 0) return;
  const int columns = static_cast<int>(in.size()), rows = static_cast<int>(out.size());
  std::vector<std::uint8_t> tables(32 * in.size() * out.size());
  ec_init_tables(columns, rows, matrix.data(), tables.data());
  ec_encode_data(static_cast<int>(bytes), columns, rows, tables.data(), const_cast<std::uint8_t**>(in.data()),
                 out.data());
}

/// The shards of one block that have arrived, by their place in the block.
struct ArrivedBlock {
  std::vector<const std::uint8_t*> data;                    ///< null: missing
  std::vector<std::pair<int, const std::uint8_t*>> parity;  ///< place and bytes
};

/// Inverse of the Cauchy matrix 1 / (x_i + y_j): b_ij = f_j g_i / (x_j + y_i) with
/// f_j = prod_k (x_j + y_k) / prod_{k != j} (x_j + x_k), g_i = prod_k (x_k + y_i) / prod_{k != i} (y_i + y_k)
/// [Schechter 1959, On the inversion of certain matrices]; n^2 products where elimination takes n^3.
std::vector<std::uint8_t> inverse_cauchy(const std::vector<std::uint8_t>& x, const std::vector<std::uint8_t>& y) {
  const auto factors = [](const std::vector<std::uint8_t>& own, const std::vector<std::uint8_t>& other) {
    std::vector<std::uint8_t> out;
    for (std::size_t i = 0; i < own.size(); ++i) {
      std::uint8_t above = 1, below = 1;
      for (std::size_t k = 0; k < own.size(); ++k) {
        above = gf_mul(above, own[i] ^ other[k]);
        if (k != i) below = gf_mul(below, own[i] ^ own[k]);
      }
      out.push_back(gf_mul(above, gf_inv(below)));
    }
    return out;
  };
  const std::vector<std::uint8_t> f = factors(x, y), g = factors(y, x);
  std::vector<std::uint8_t> inverse;
  for (std::size_t i = 0; i < y.size(); ++i)
    for (std::size_t j = 0; j < x.size(); ++j) inverse.push_back(gf_mul(gf_mul(f[j], g[i]), gf_inv(x[j] ^ y[i])));
  return inverse;
}

/// The missing data of a block. With the lost columns L of the code A and as many rows of parity p:
/// A_L d_L = p + A_K d_K, where K is what is there.
bool recover(const ArrivedBlock& block, std::vector<std::uint8_t*>& lost_out, const std::vector<int>& lost,
             std::size_t bytes) {
  const std::size_t num_lost = lost.size();
  if (block.parity.size() < num_lost) return false;
  const int k = static_cast<int>(block.data.size());
  std::vector<std::uint8_t> x, y(lost.begin(), lost.end());
  for (std::size_t r = 0; r < num_lost; ++r) x.push_back(static_cast<std::uint8_t>(k + block.parity[r].first));

  std::vector<const std::uint8_t*> known;
  std::vector<int> known_at;
  for (int i = 0; i < k; ++i)
    if (const std::uint8_t* there = block.data[static_cast<std::size_t>(i)]) {
      known.push_back(there);
      known_at.push_back(i);
    }
  std::vector<std::uint8_t> a_known;
  for (std::size_t r = 0; r < num_lost; ++r)
    for (const int i : known_at) a_known.push_back(cauchy(k, block.parity[r].first, i));
  std::vector<std::uint8_t> rest(num_lost * bytes);
  std::vector<std::uint8_t*> rest_rows;
  for (std::size_t r = 0; r < num_lost; ++r) rest_rows.push_back(rest.data() + r * bytes);
  multiply(a_known, known, rest_rows, bytes);
  for (std::size_t r = 0; r < num_lost; ++r)
    for (std::size_t i = 0; i < bytes; ++i) rest_rows[r][i] ^= block.parity[r].second[i];

  std::vector<std::uint8_t> inverse = inverse_cauchy(x, y);
  std::vector<const std::uint8_t*> in(rest_rows.begin(), rest_rows.end());
  multiply(inverse, in, lost_out, bytes);
  return true;
}

}  // namespace

int num_blocks(int data) { return (data + kMostBlockData - 1) / kMostBlockData; }

int shards_in_block(int count, int blocks, int block) { return count / blocks + (block < count % blocks ? 1 : 0); }

int most_parity_shards(int data) {
  if (data <= 0) return 0;
  const int blocks = num_blocks(data);
  return blocks * (kMostBlockShards - shards_in_block(data, blocks, 0));
}

double undecoded_probability(int data, int parity, double loss) {
  const int blocks = num_blocks(data);
  double log_decoded = 0;
  for (int b = 0; b < blocks; ++b)
    log_decoded +=
        std::log1p(-block_undecoded(shards_in_block(data, blocks, b), shards_in_block(parity, blocks, b), loss));
  return -std::expm1(log_decoded);
}

int parity_shards(int data, double loss) {
  const double p = std::clamp(loss, 0.0, kMostLoss) + kLossMargin;
  int low = 0, high = most_parity_shards(data);  // the answer is in [low, high]: each shard more helps
  while (low < high) {
    const int middle = (low + high) / 2;
    if (undecoded_probability(data, middle, p) <= kUndecodedShare)
      high = middle;
    else
      low = middle + 1;
  }
  return low;
}

std::vector<std::uint8_t> encode_parity(std::span<const std::uint8_t> data, int num_data, int num_parity,
                                        std::size_t shard_bytes) {
  KT_ASSERT(data.size() == static_cast<std::size_t>(num_data) * shard_bytes);
  KT_ASSERT(num_parity >= 0 && num_parity <= most_parity_shards(num_data));
  std::vector<std::uint8_t> parity(static_cast<std::size_t>(num_parity) * shard_bytes);
  const int blocks = num_blocks(num_data);
  for (int b = 0; b < blocks; ++b) {
    const int k = shards_in_block(num_data, blocks, b), m = shards_in_block(num_parity, blocks, b);
    std::vector<const std::uint8_t*> in;
    std::vector<std::uint8_t*> out;
    std::vector<std::uint8_t> matrix;
    for (int i = 0; i < k; ++i) in.push_back(data.data() + static_cast<std::size_t>(b + i * blocks) * shard_bytes);
    for (int j = 0; j < m; ++j) {
      out.push_back(parity.data() + static_cast<std::size_t>(b + j * blocks) * shard_bytes);
      for (int i = 0; i < k; ++i) matrix.push_back(cauchy(k, j, i));
    }
    multiply(matrix, in, out, shard_bytes);
  }
  return parity;
}

bool decode_parity(std::span<const ArrivedShard> arrived, int num_data, int num_parity, std::size_t shard_bytes,
                   std::span<std::uint8_t> out) {
  KT_ASSERT(out.size() == static_cast<std::size_t>(num_data) * shard_bytes);
  const int blocks = num_blocks(num_data);
  std::vector<ArrivedBlock> block(static_cast<std::size_t>(blocks));
  for (int b = 0; b < blocks; ++b)
    block[static_cast<std::size_t>(b)].data.resize(static_cast<std::size_t>(shards_in_block(num_data, blocks, b)));
  for (const ArrivedShard& shard : arrived) {
    if (shard.index < 0 || shard.index >= num_data + num_parity) return false;
    const bool is_data = shard.index < num_data;
    const int place = is_data ? shard.index : shard.index - num_data;
    ArrivedBlock& own = block[static_cast<std::size_t>(place % blocks)];
    if (is_data)
      own.data[static_cast<std::size_t>(place / blocks)] = shard.bytes;
    else
      own.parity.emplace_back(place / blocks, shard.bytes);
  }
  for (int b = 0; b < blocks; ++b) {
    const ArrivedBlock& own = block[static_cast<std::size_t>(b)];
    std::vector<int> lost;
    std::vector<std::uint8_t*> lost_out;
    for (int i = 0; i < static_cast<int>(own.data.size()); ++i) {
      std::uint8_t* to = out.data() + static_cast<std::size_t>(b + i * blocks) * shard_bytes;
      if (const std::uint8_t* bytes = own.data[static_cast<std::size_t>(i)]) {
        std::copy(bytes, bytes + shard_bytes, to);
      } else {
        lost.push_back(i);
        lost_out.push_back(to);
      }
    }
    if (!lost.empty() && !recover(own, lost_out, lost, shard_bytes)) return false;
  }
  return true;
}

}  // namespace kt
