// CPU time of a model on its way: parity, seals, joining. 62 and 206 shards of 1152 bytes with 55 % parity are the
// least and the most that the scenes' models take.
#include <benchmark/benchmark.h>
#include <malloc.h>

#include <random>

#include "network/channel/sealed.hpp"
#include "network/channel/shards.hpp"

namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes random_bytes(std::size_t size) {
  std::mt19937_64 random(1);
  Bytes bytes(size);
  for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(random());
  return bytes;
}

void seal_and_open_100_datagrams(benchmark::State& state) {
  const kt::SealKey key = kt::new_seal_key();
  kt::Sealer sealer(key, 0);
  kt::Opener opener(key, 0);
  const Bytes sent = random_bytes(1200 - kt::kSealOverhead);
  Bytes datagram, payload;
  for (auto _ : state)
    for (int i = 0; i < 100; ++i) {
      sealer.seal(sent, datagram);
      if (!opener.open(datagram, payload)) state.SkipWithError("not opened");
    }
}
BENCHMARK(seal_and_open_100_datagrams)->Unit(benchmark::kMicrosecond);

int parity_of(int data) { return (data * 55 + 99) / 100; }

void encode(benchmark::State& state) {
  const int data = static_cast<int>(state.range(0));
  const Bytes bytes = random_bytes(static_cast<std::size_t>(data) * kt::kShardContent);
  for (auto _ : state) benchmark::DoNotOptimize(kt::encode_parity(bytes, data, parity_of(data), kt::kShardContent));
}
BENCHMARK(encode)->Arg(62)->Arg(206)->Unit(benchmark::kMicrosecond);

/// As many data shards are lost as parity makes up for: the most work.
void decode(benchmark::State& state) {
  const int data = static_cast<int>(state.range(0)), parity = parity_of(data);
  Bytes all = random_bytes(static_cast<std::size_t>(data) * kt::kShardContent);
  const Bytes sent = all, extra = kt::encode_parity(all, data, parity, kt::kShardContent);
  all.insert(all.end(), extra.begin(), extra.end());
  std::vector<kt::ArrivedShard> arrived;
  for (int i = parity; i < data + parity; ++i)
    arrived.push_back({i, all.data() + static_cast<std::size_t>(i) * kt::kShardContent});
  Bytes out(sent.size());
  for (auto _ : state)
    if (!kt::decode_parity(arrived, data, parity, kt::kShardContent, out)) state.SkipWithError("not decoded");
  if (out != sent) state.SkipWithError("decoded something else");
}
BENCHMARK(decode)->Arg(62)->Arg(206)->Unit(benchmark::kMicrosecond);

/// Split and join at 20 % loss, of which the first shards are lost.
void split_and_join(benchmark::State& state) {
  kt::Message message;
  message.bytes = random_bytes(static_cast<std::size_t>(state.range(0)) * kt::kShardContent);
  kt::ShardJoiner joiner;
  for (auto _ : state) {
    ++message.number;
    const auto payloads = kt::split(message, 0.2);
    bool is_complete = false;
    for (std::size_t i = payloads.size() / 5; i < payloads.size(); ++i)
      is_complete |= joiner.take(payloads[i]).has_value();
    if (!is_complete) state.SkipWithError("not complete");
  }
}
BENCHMARK(split_and_join)->Arg(62)->Arg(206)->Unit(benchmark::kMicrosecond);

}  // namespace

int main(int argc, char** argv) {
  mallopt(M_MMAP_THRESHOLD, 1 << 30);  // as the engine's runs do: or the system's pages take ten times the work's time
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
