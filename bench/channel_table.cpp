// Age of models that come over a bad network: through the relay of the tests, 30 a second, by delay and loss, with
// parity that follows the measured loss and without any.
//
//     channel_table [SECONDS [BYTES]]      of each cell; default 3 s, 74000 bytes
#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <thread>

#include "network/channel/paced_sender.hpp"
#include "network/channel/sealed.hpp"
#include "network/channel/shards.hpp"
#include "network/channel/udp_socket.hpp"
#include "network/udp_relay.hpp"

namespace {

using Clock = std::chrono::steady_clock;
using Bytes = std::vector<std::uint8_t>;
constexpr double kWarm = 0.5;  // [s], while the loss is not known yet
constexpr auto kPeriod = std::chrono::microseconds(33333);

struct Cell {
  double delay_ms = 0, loss = 0;
  bool parity = true;
};

struct Result {
  long sent = 0;
  std::vector<double> ages;  ///< [ms]
  double mbit = 0;           ///< a second
  double measured_loss = 0;
};

Result measure(const Cell& cell, double seconds, std::size_t bytes) {
  const kt::SealKey key = kt::new_seal_key();
  kt::UdpSocket receiver = kt::UdpSocket::bound("127.0.0.1", 0);
  kt::UdpRelayOptions options;
  options.host_port = receiver.port();
  options.delay_ms = cell.delay_ms;
  options.loss = cell.loss;
  kt::UdpRelay relay(options);
  std::atomic<bool> stop{false};
  std::atomic<double> loss{kt::kLossUntilKnown};
  Result out;
  const auto start = Clock::now();
  const auto now_s = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };

  std::thread taker([&] {
    kt::Opener opener(key, 0);
    kt::ShardJoiner joiner;
    Bytes datagram, payload;
    kt::Peer from;
    while (!stop) {
      if (!receiver.receive(datagram, from, 20) || !opener.open(datagram, payload)) continue;
      loss = opener.loss().value_or(kt::kLossUntilKnown);
      const auto message = joiner.take(payload);
      if (!message) continue;
      double sent_at = 0;
      std::memcpy(&sent_at, message->bytes.data(), sizeof sent_at);
      if (sent_at > kWarm) out.ages.push_back(1e3 * (now_s() - sent_at));
    }
  });

  kt::UdpSocket socket = kt::UdpSocket::connected_to("127.0.0.1", relay.port());
  kt::Sealer sealer(key, 0);
  kt::PacedSender sender;
  Bytes datagram;
  kt::Message model;
  model.bytes.resize(bytes);
  auto next = start;
  while (now_s() < seconds + kWarm) {
    if (Clock::now() >= next) {
      next += kPeriod;
      ++model.number;
      const double now = now_s();
      out.sent += now > kWarm;
      std::memcpy(model.bytes.data(), &now, sizeof now);
      sender.put(kt::split(model, cell.parity ? loss.load() : -1), false);
    }
    const auto wait = sender.pump(Clock::now(), [&](std::span<const std::uint8_t> payload) {
      sealer.seal(payload, datagram);
      socket.send(datagram);
    });
    std::this_thread::sleep_for(std::min<Clock::duration>(wait ? *wait : kPeriod, next - Clock::now()));
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(static_cast<int>(cell.delay_ms) + 100));
  stop = true;
  taker.join();
  out.mbit = 8e-6 * static_cast<double>(relay.counts().bytes[0]) / (seconds + kWarm);
  out.measured_loss = loss;
  std::sort(out.ages.begin(), out.ages.end());
  return out;
}

double percentile_of(const std::vector<double>& sorted, double share) {
  return sorted.empty() ? 0 : sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1) + 0.5)];
}

}  // namespace

int main(int argc, char** argv) {
  mallopt(M_MMAP_THRESHOLD, 1 << 30);  // as the engine's runs do
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  const double seconds = argc > 1 ? std::atof(argv[1]) : 3;
  const std::size_t bytes = argc > 2 ? static_cast<std::size_t>(std::atol(argv[2])) : 74000;
  std::printf(
      "| each way [ms] | lost | parity: arrived | age p50 / p99 [ms] | Mbit/s | loss measured | none: arrived |\n");
  std::printf("|---|---|---|---|---|---|---|\n");
  for (const double delay : {0.0, 25.0, 50.0, 100.0, 200.0})
    for (const double loss : {0.0, 0.05, 0.2, 0.4}) {
      const Result with = measure({delay, loss, true}, seconds, bytes),
                   none = measure({delay, loss, false}, seconds, bytes);
      std::printf("| %.0f | %.0f %% | %zu of %ld | %.0f / %.0f | %.1f | %.1f %% | %zu of %ld |\n", delay, 100 * loss,
                  with.ages.size(), with.sent, percentile_of(with.ages, 0.5), percentile_of(with.ages, 0.99), with.mbit,
                  100 * with.measured_loss, none.ages.size(), none.sent);
      std::fflush(stdout);
    }
}
