#pragma once
// Parity shards (Reed-Solomon): from any `data` of a block's data + parity shards its data comes back, so that a
// message over a bad network needs no second try.
//
// A code over GF(256) with a Cauchy matrix, all of whose square parts are regular (ISA-L: erasure_code.h). A block has
// at most 128 data shards and 255 in all; of a message's B blocks shard i belongs to block i mod B, data and parity
// alike, so that a run of lost datagrams is shared by all.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace kt {

constexpr int kMostBlockData = 128;       ///< data shards of a block
constexpr int kMostBlockShards = 255;     ///< data and parity shards of a block
constexpr double kLossMargin = 0.02;      ///< parity is for this much more loss than was measured
constexpr double kLossUntilKnown = 0.2;   ///< that parity is for before any was measured
constexpr double kMostLoss = 0.5;         ///< parity is for no more loss than this (and the margin)
constexpr double kUndecodedShare = 1e-3;  ///< of messages, at the measured loss and the margin

/// Blocks of a message of `data` shards: 0 for 0.
int num_blocks(int data);

/// Of `count` shards those in `block`, of num_blocks(data) = `blocks`.
int shards_in_block(int count, int blocks, int block);

/// The most parity shards that fit beside `data` shards.
int most_parity_shards(int data);

/// What parity is for on the way to the other end: the loss that it has told; before that, what is lost on the way from
/// it.
inline double loss_for_parity(const std::optional<double>& told, const std::optional<double>& from_there) {
  return told.value_or(from_there.value_or(kLossUntilKnown));
}

/// Probability that a message does not arrive whole, when each shard is lost by itself with probability `loss`: that of
/// some block more than its parity shards are lost. Exact (binomial).
double undecoded_probability(int data, int parity, double loss);

/// The fewest parity shards with undecoded_probability <= kUndecodedShare at loss + kLossMargin; at most
/// most_parity_shards.
/// @param loss  share of datagrams that get lost, measured, in [0, 1]; more than kMostLoss counts as that
int parity_shards(int data, double loss);

/// The parity shards, one after the other.
/// @param data         the data shards, one after the other: num_data · shard_bytes
/// @param num_parity   in [0, most_parity_shards(num_data)]
std::vector<std::uint8_t> encode_parity(std::span<const std::uint8_t> data, int num_data, int num_parity,
                                        std::size_t shard_bytes);

/// A shard that has arrived; data shards have index 0 .. num_data - 1, parity shards those that follow.
struct ArrivedShard {
  int index = 0;
  const std::uint8_t* bytes = nullptr;  ///< shard_bytes of them
};

/// The data shards, one after the other, from those that have arrived.
/// @param arrived  each index at most once, in any order
/// @param out      num_data · shard_bytes
/// @returns false, and out is undefined: of a block fewer than its data shards have arrived
bool decode_parity(std::span<const ArrivedShard> arrived, int num_data, int num_parity, std::size_t shard_bytes,
                   std::span<std::uint8_t> out);

}  // namespace kt
