// Payloads of the network's channel: whatever they are, no message comes twice, none older than one before it (but of
// the kinds that keep all), memory is bounded; what was never sealed is not opened; of a message that was split, any
// shards that suffice give it back.
//
//     scripts/fuzz shard_fuzz
#include <algorithm>
#include <cstdint>
#include <map>
#include <set>

#include "network/channel/sealed.hpp"
#include "network/channel/shards.hpp"
#include "tests/fuzz/require.hpp"

using kt::fuzz::require;

namespace {

using Bytes = std::span<const std::uint8_t>;

/// The input is payloads, each behind its length (u16, little-endian).
void join(Bytes input) {
  kt::ShardJoiner joiner;
  kt::Opener opener(kt::SealKey{1, 2, 3}, 0);
  std::map<std::uint8_t, std::set<std::uint32_t>> given;
  std::vector<std::uint8_t> opened;
  while (input.size() >= 2) {
    const std::size_t size = std::min<std::size_t>(input[0] + 256U * input[1], input.size() - 2);
    const Bytes payload = input.subspan(2, size);
    input = input.subspan(2 + size);
    require(!opener.open(payload, opened), "nobody sealed it");
    const auto message = joiner.take(payload);
    require(joiner.held_bytes() <= kt::ShardJoiner::kMostHeldBytes, "memory is bounded");
    if (!message) continue;
    require(message->bytes.size() <= kt::kMostMessageBytes, "a message has a size");
    std::set<std::uint32_t>& of_kind = given[message->kind];
    require(message->kind & kt::kKeepAll || of_kind.empty() || message->number > *of_kind.rbegin(), "the newest wins");
    require(of_kind.insert(message->number).second, "each once");
  }
  const kt::JoinerCounts c = joiner.counts();
  require(c.payloads >= c.malformed + c.disagreeing + c.repeated + c.surplus + c.old + c.messages, "each is counted");
}

/// The input is a size, a loss and the order in which shards come; what is left over does not come.
void split_and_join(Bytes input) {
  if (input.size() < 5) return;
  kt::Message sent;
  sent.number = input[0];
  sent.kind = input[1] % 16 | (input[1] & kt::kKeepAll);
  sent.bytes.resize(input[2] % 16 * 1200U + input[3]);  // a few shards: more take long
  for (std::size_t i = 0; i < sent.bytes.size(); ++i)
    sent.bytes[i] = static_cast<std::uint8_t>(i * input[3] + (i >> 8));
  const auto payloads = kt::split(sent, input[4] / 256.0);
  input = input.subspan(5);
  kt::ShardJoiner joiner;
  std::set<std::size_t> came;
  bool is_complete = false;
  for (; input.size() >= 2 && !is_complete; input = input.subspan(2)) {
    const std::size_t index = (input[0] + 256U * input[1]) % payloads.size();
    came.insert(index);
    const auto message = joiner.take(payloads[index]);
    is_complete = message.has_value();
    if (message) require(message->bytes == sent.bytes && message->number == sent.number, "it is the same message");
  }
  const std::size_t data = std::max<std::size_t>(1, (sent.bytes.size() + kt::kShardContent - 1) / kt::kShardContent);
  if (data <= 128) require(is_complete == (came.size() >= data), "as many shards as it has data are enough");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const Bytes rest(data + 1, size - 1);
  if (data[0] % 2)
    split_and_join(rest);
  else
    join(rest);
  return 0;
}
