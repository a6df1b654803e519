#pragma once
// Messages over datagrams: split into shards with parity (parity.hpp), joined from any that are enough. The newest
// complete message of a kind wins; nothing is asked for twice.
//
// A payload is a header of 16 bytes, little-endian, and a part of the message:
//   kind u8, format u8 (kShardFormat), data shards u16, parity shards u16, shard index u16, number u32, total bytes
//   u32.
// All shards of a message have the same length, the last of the data is filled up with zeros.
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "network/channel/parity.hpp"

namespace kt {

constexpr std::size_t kShardHeader = 16;                           ///< [bytes]
constexpr std::size_t kShardContent = 1152;                        ///< the most message bytes of a shard
constexpr std::size_t kShardBytes = kShardHeader + kShardContent;  ///< payload; sealed: 1192, below any path's 1200
constexpr std::size_t kMostMessageBytes = std::size_t{2} << 20;    ///< of a message
constexpr std::uint8_t kShardFormat = 1;

/// Set in a kind: each of its messages is given out, once, in whatever order they come complete. Without it only those
/// newer than all given out before.
constexpr std::uint8_t kKeepAll = 0x80;
constexpr int kNumKinds = 16;  ///< a kind is 0 .. 15, with or without kKeepAll

struct Message {
  std::uint8_t kind = 0;
  std::uint32_t number = 0;  ///< of its kind, from 0 on; the sender's newest is its largest
  std::vector<std::uint8_t> bytes;
};

/// Payloads of at most kShardBytes, those of data first, for Sealer. Throws std::invalid_argument (our own
/// mistake): no such kind, more than kMostMessageBytes.
/// @param loss  what the number of parity shards follows (parity_shards); < 0: no parity
std::vector<std::vector<std::uint8_t>> split(const Message& message, double loss);

/// What became of payloads and messages.
struct JoinerCounts {
  long payloads = 0;     ///< all of them; each of the next five is one of these, the rest are parts of messages
  long malformed = 0;    ///< no header, no such kind, counts or sizes that cannot be
  long disagreeing = 0;  ///< says another size or other counts than the first payload of the same message
  long repeated = 0;     ///< has come before
  long surplus = 0;      ///< the rest of a message (or of its block) that was complete without it
  long old = 0;          ///< of a message older than one given out, or than those that are being joined
  long messages = 0;     ///< given out
  long recovered = 0;    ///< of these with the help of parity
  long given_up = 0;     ///< incomplete when a newer one was complete, or when there was no more room
};

/// Joins payloads to messages. Whatever the payloads are, it neither throws nor holds more than kMostHeldBytes and a
/// table of a few KB a message.
class ShardJoiner {
 public:
  static constexpr int kMostIncomplete = 4;       ///< messages a kind
  static constexpr int kMostIncompleteKept = 32;  ///< with kKeepAll: small ones
  static constexpr std::size_t kMostHeldBytes = std::size_t{16} << 20;
  static constexpr std::uint32_t kKeepAllWindow = 4096;  ///< numbers behind the newest that still count

  /// @returns the message that this payload completes
  std::optional<Message> take(std::span<const std::uint8_t> payload);

  JoinerCounts counts() const { return counts_; }
  std::size_t held_bytes() const { return held_; }  ///< of incomplete messages

 private:
  struct Header {
    std::uint8_t kind = 0;
    int data = 0, parity = 0, index = 0;
    std::uint32_t number = 0, total = 0;
    bool same_message(const Header& other) const;
  };
  struct Incomplete {
    explicit Incomplete(const Header& h);
    Header header;             ///< of the first payload; the others must agree
    std::vector<bool> has;     ///< by shard
    std::vector<int> missing;  ///< by block: so many more shards
    int incomplete_blocks = 0;
    std::vector<int> index;           ///< of the shards in bytes
    std::vector<std::uint8_t> bytes;  ///< contents, as they came
  };
  struct Kind {
    std::map<std::uint32_t, Incomplete> incomplete;  ///< by number
    std::optional<std::uint32_t> newest;             ///< of those given out
    std::vector<bool> given;                         ///< kKeepAll: by number mod kKeepAllWindow
  };
  static std::optional<Header> read_header(std::span<const std::uint8_t> payload);
  bool is_old(const Kind& kind, const Header& header) const;
  bool make_room(Kind& kind, const Header& header);
  void make_bytes(std::size_t more, const Incomplete* keep);
  void drop(Kind& kind, std::map<std::uint32_t, Incomplete>::iterator one);
  void mark_given(Kind& kind, const Header& header);
  std::optional<Message> finish(Kind& kind, std::map<std::uint32_t, Incomplete>::iterator one);

  std::map<std::uint8_t, Kind> kinds_;
  std::size_t held_ = 0;
  JoinerCounts counts_;
};

}  // namespace kt
