#include "network/channel/shards.hpp"

#include <algorithm>
#include <stdexcept>

#include "core/base/error.hpp"

namespace kt {
namespace {

void put_number(std::uint8_t* to, std::uint32_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) to[i] = static_cast<std::uint8_t>(value >> (8 * i));
}

std::uint32_t get_number(const std::uint8_t* from, int bytes) {
  std::uint32_t value = 0;
  for (int i = 0; i < bytes; ++i) value |= static_cast<std::uint32_t>(from[i]) << (8 * i);
  return value;
}

bool is_kind(std::uint8_t kind) { return (kind & ~kKeepAll) < kNumKinds; }

/// Data shards of a message: one at least.
int num_data_shards(std::size_t total) {
  return static_cast<int>(std::max<std::size_t>(1, (total + kShardContent - 1) / kShardContent));
}

/// All shards of a message have as many bytes of it; one at least.
std::size_t shard_content(std::size_t total, int data) {
  return (std::max<std::size_t>(total, 1) + static_cast<std::size_t>(data) - 1) / static_cast<std::size_t>(data);
}

}  // namespace

std::vector<std::vector<std::uint8_t>> split(const Message& message, double loss) {
  const std::size_t total = message.bytes.size();
  if (!is_kind(message.kind)) throw std::invalid_argument(text("split: no kind ", int{message.kind}));
  if (total > kMostMessageBytes)
    throw std::invalid_argument(text("split: a message of ", total, " bytes; at most ", kMostMessageBytes));
  const int data = num_data_shards(total), parity = loss < 0 ? 0 : parity_shards(data, loss);
  const std::size_t content = shard_content(total, data);
  std::vector<std::uint8_t> filled = message.bytes;
  filled.resize(static_cast<std::size_t>(data) * content);
  const std::vector<std::uint8_t> extra = encode_parity(filled, data, parity, content);

  std::vector<std::vector<std::uint8_t>> payloads(static_cast<std::size_t>(data + parity));
  for (std::size_t i = 0; i < payloads.size(); ++i) {
    std::vector<std::uint8_t>& p = payloads[i];
    p.resize(kShardHeader + content);
    p[0] = message.kind;
    p[1] = kShardFormat;
    put_number(&p[2], static_cast<std::uint32_t>(data), 2);
    put_number(&p[4], static_cast<std::uint32_t>(parity), 2);
    put_number(&p[6], static_cast<std::uint32_t>(i), 2);
    put_number(&p[8], message.number, 4);
    put_number(&p[12], static_cast<std::uint32_t>(total), 4);
    const bool is_data = i < static_cast<std::size_t>(data);
    const std::uint8_t* from =
        is_data ? filled.data() + i * content : extra.data() + (i - static_cast<std::size_t>(data)) * content;
    std::copy_n(from, content, p.begin() + static_cast<std::ptrdiff_t>(kShardHeader));
  }
  return payloads;
}

bool ShardJoiner::Header::same_message(const Header& other) const {
  return kind == other.kind && number == other.number && data == other.data && parity == other.parity &&
         total == other.total;
}

/// None unless every number can be and agrees with the others and with the payload's length.
std::optional<ShardJoiner::Header> ShardJoiner::read_header(std::span<const std::uint8_t> payload) {
  if (payload.size() < kShardHeader || payload.size() > kShardBytes) return std::nullopt;
  const std::uint8_t* p = payload.data();
  Header h;
  h.kind = p[0];
  h.data = static_cast<int>(get_number(p + 2, 2));
  h.parity = static_cast<int>(get_number(p + 4, 2));
  h.index = static_cast<int>(get_number(p + 6, 2));
  h.number = get_number(p + 8, 4);
  h.total = get_number(p + 12, 4);
  if (!is_kind(h.kind) || p[1] != kShardFormat || h.total > kMostMessageBytes) return std::nullopt;
  if (h.data != num_data_shards(h.total) || h.parity > most_parity_shards(h.data)) return std::nullopt;
  if (h.index >= h.data + h.parity) return std::nullopt;
  if (payload.size() != kShardHeader + shard_content(h.total, h.data)) return std::nullopt;
  return h;
}

bool ShardJoiner::is_old(const Kind& kind, const Header& header) const {
  if (!kind.newest || header.number > *kind.newest) return false;
  if (!(header.kind & kKeepAll)) return true;
  return *kind.newest - header.number >= kKeepAllWindow || kind.given[header.number % kKeepAllWindow];
}

void ShardJoiner::drop(Kind& kind, std::map<std::uint32_t, Incomplete>::iterator one) {
  held_ -= one->second.bytes.size();
  kind.incomplete.erase(one);
}

/// Makes room for a message: of too many of its kind the oldest goes, of too many bytes the oldest of the kind that
/// holds most. @returns false: the message itself is the oldest
bool ShardJoiner::make_room(Kind& kind, const Header& header) {
  const std::size_t most = static_cast<std::size_t>(header.kind & kKeepAll ? kMostIncompleteKept : kMostIncomplete);
  if (kind.incomplete.size() < most) return true;
  if (header.number < kind.incomplete.begin()->first) return false;
  drop(kind, kind.incomplete.begin());
  ++counts_.given_up;
  return true;
}

/// Drops incomplete messages until `more` bytes fit: the oldest of the kind that holds most, but not `keep`.
void ShardJoiner::make_bytes(std::size_t more, const Incomplete* keep) {
  while (held_ + more > kMostHeldBytes) {
    Kind* most = nullptr;
    std::size_t most_bytes = 0;
    for (auto& [name, kind] : kinds_) {
      std::size_t bytes = 0;
      for (const auto& [number, one] : kind.incomplete) bytes += &one == keep ? 0 : one.bytes.size();
      if (bytes > most_bytes) {
        most = &kind;
        most_bytes = bytes;
      }
    }
    if (!most) return;
    auto oldest = most->incomplete.begin();
    while (&oldest->second == keep || oldest->second.bytes.empty()) ++oldest;
    drop(*most, oldest);
    ++counts_.given_up;
  }
}

void ShardJoiner::mark_given(Kind& kind, const Header& header) {
  const std::uint32_t number = header.number;
  if (header.kind & kKeepAll) {
    kind.given.resize(kKeepAllWindow);
    if (kind.newest && number > *kind.newest) {
      const std::uint32_t steps = std::min(number - *kind.newest, kKeepAllWindow);
      for (std::uint32_t i = 0; i < steps; ++i) kind.given[(number - i) % kKeepAllWindow] = false;
    }
    kind.given[number % kKeepAllWindow] = true;
  }
  kind.newest = std::max(number, kind.newest.value_or(0));
  const auto outlived = [&](std::uint32_t other) {
    return header.kind & kKeepAll ? other < *kind.newest && *kind.newest - other >= kKeepAllWindow : other < number;
  };
  while (!kind.incomplete.empty() && outlived(kind.incomplete.begin()->first)) {
    drop(kind, kind.incomplete.begin());
    ++counts_.given_up;
  }
}

/// Decodes a message that has enough shards, and forgets those that it outlives.
std::optional<Message> ShardJoiner::finish(Kind& kind, std::map<std::uint32_t, Incomplete>::iterator one) {
  const Incomplete& m = one->second;
  const Header header = m.header;
  const std::size_t content = shard_content(header.total, header.data);
  std::vector<ArrivedShard> arrived;
  for (std::size_t i = 0; i < m.index.size(); ++i) arrived.push_back({m.index[i], m.bytes.data() + i * content});
  Message message{header.kind, header.number,
                  std::vector<std::uint8_t>(static_cast<std::size_t>(header.data) * content)};
  const bool decoded = decode_parity(arrived, header.data, header.parity, content, message.bytes);
  const bool helped = std::ranges::any_of(m.index, [&](int i) { return i >= header.data; });
  drop(kind, one);
  if (!decoded) {  // cannot be: each block has its shards
    ++counts_.given_up;
    return std::nullopt;
  }
  message.bytes.resize(header.total);
  mark_given(kind, header);
  ++counts_.messages;
  if (helped) ++counts_.recovered;
  return message;
}

std::optional<Message> ShardJoiner::take(std::span<const std::uint8_t> payload) {
  ++counts_.payloads;
  const std::optional<Header> header = read_header(payload);
  if (!header) {
    ++counts_.malformed;
    return std::nullopt;
  }
  Kind& kind = kinds_[header->kind];
  if (is_old(kind, *header)) {
    ++counts_.old;
    return std::nullopt;
  }
  auto found = kind.incomplete.find(header->number);
  if (found == kind.incomplete.end()) {
    if (!make_room(kind, *header)) {
      ++counts_.old;
      return std::nullopt;
    }
    found = kind.incomplete.emplace(header->number, Incomplete(*header)).first;
  }
  Incomplete& one = found->second;
  if (!one.header.same_message(*header)) {
    ++counts_.disagreeing;
    return std::nullopt;
  }
  const std::size_t index = static_cast<std::size_t>(header->index);
  if (one.has[index]) {
    ++counts_.repeated;
    return std::nullopt;
  }
  one.has[index] = true;
  const int place = header->index < header->data ? header->index : header->index - header->data;
  int& missing = one.missing[static_cast<std::size_t>(place) % one.missing.size()];
  if (missing == 0) {
    ++counts_.surplus;
    return std::nullopt;
  }
  const std::span<const std::uint8_t> content = payload.subspan(kShardHeader);
  make_bytes(content.size(), &one);
  one.index.push_back(header->index);
  one.bytes.insert(one.bytes.end(), content.begin(), content.end());
  held_ += content.size();
  if (--missing > 0 || --one.incomplete_blocks > 0) return std::nullopt;
  return finish(kind, found);
}

ShardJoiner::Incomplete::Incomplete(const Header& h)
    : header(h), has(static_cast<std::size_t>(h.data + h.parity)), incomplete_blocks(num_blocks(h.data)) {
  for (int b = 0; b < incomplete_blocks; ++b) missing.push_back(shards_in_block(h.data, incomplete_blocks, b));
}

}  // namespace kt
