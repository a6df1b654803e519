#include "network/udp_relay.hpp"

#include <poll.h>

#include <algorithm>
#include <chrono>
#include <mutex>
#include <queue>
#include <random>
#include <thread>
#include <vector>

#include "network/channel/udp_socket.hpp"

namespace kt {
namespace {

using RelayClock = std::chrono::steady_clock;

RelayClock::duration milliseconds_of(double ms) {
  return std::chrono::duration_cast<RelayClock::duration>(std::chrono::duration<double, std::milli>(ms));
}

struct OnItsWay {
  RelayClock::time_point due;
  long number = 0;  ///< of those due at the same time the first goes first
  std::size_t way = 0;
  std::vector<std::uint8_t> datagram;
  bool operator<(const OnItsWay& other) const { return std::pair(due, number) > std::pair(other.due, other.number); }
};

}  // namespace

struct UdpRelay::Parts {
  explicit Parts(const UdpRelayOptions& o)
      : options(o),
        to_client(UdpSocket::bound(o.address, o.port)),
        to_server(UdpSocket::connected_to(o.host, o.host_port)),
        random{std::mt19937_64(o.seed), std::mt19937_64(o.seed + 1)},
        loss(o.loss),
        delay_ms(o.delay_ms) {}

  void run();
  void arrived(std::size_t way, std::vector<std::uint8_t> datagram);
  void send_due(RelayClock::time_point now);

  UdpRelayOptions options;
  UdpSocket to_client, to_server;
  Peer client;
  std::array<std::mt19937_64, 2> random;  ///< a way has its own: what it does to the n-th datagram depends on n alone
  std::array<RelayClock::time_point, 2> free_at{};  ///< when the line has sent what it took
  std::priority_queue<OnItsWay> queue;
  long number = 0;
  std::atomic<double> loss, delay_ms;
  std::atomic<bool> dark{false}, stop{false};
  mutable std::mutex mutex;  ///< of counts
  UdpRelayCounts counts;
  std::thread thread;
};

/// Decides what becomes of a datagram; each takes as many random numbers as any other.
void UdpRelay::Parts::arrived(std::size_t way, std::vector<std::uint8_t> datagram) {
  const auto draw = [&] { return std::uniform_real_distribution<double>(0, 1)(random[way]); };
  const bool lose = draw() < loss || dark, twice = draw() < options.duplicate, later = draw() < options.reorder;
  const double jitter[2] = {draw() * options.jitter_ms, draw() * options.jitter_ms};
  const std::lock_guard lock(mutex);
  ++counts.received[way];
  counts.bytes[way] += static_cast<long>(datagram.size());
  if (lose) {
    ++counts.lost[way];
    return;
  }
  const auto now = RelayClock::now();
  auto leaves = now;
  if (options.rate_mbit > 0) {
    if (free_at[way] > now + milliseconds_of(kQueueMs)) {
      ++counts.overflown[way];
      return;
    }
    free_at[way] =
        std::max(free_at[way], now) + milliseconds_of(8e-3 * static_cast<double>(datagram.size()) / options.rate_mbit);
    leaves = free_at[way];
  }
  counts.doubled[way] += twice;
  counts.reordered[way] += later;
  for (int copy = 0; copy <= (twice ? 1 : 0); ++copy)
    queue.push({leaves + milliseconds_of(delay_ms + jitter[copy] + (later && copy == 0 ? kReorderMs : 0)), number++,
                way, datagram});
}

void UdpRelay::Parts::send_due(RelayClock::time_point now) {
  for (; !queue.empty() && queue.top().due <= now; queue.pop()) {
    const OnItsWay& one = queue.top();
    const bool sent =
        one.way == 0 ? to_server.send(one.datagram) : client.size > 0 && to_client.send(one.datagram, client);
    const std::lock_guard lock(mutex);
    counts.sent[one.way] += sent;
  }
}

void UdpRelay::Parts::run() {
  std::vector<std::uint8_t> datagram;
  Peer from;
  while (!stop) {
    auto wait = milliseconds_of(20);
    if (!queue.empty()) wait = std::clamp(queue.top().due - RelayClock::now(), milliseconds_of(0), wait);
    std::array<pollfd, 2> items{pollfd{to_client.descriptor(), POLLIN, 0}, pollfd{to_server.descriptor(), POLLIN, 0}};
    const timespec time{0, std::chrono::nanoseconds(wait).count()};
    ::ppoll(items.data(), items.size(), &time, nullptr);
    while (to_client.receive(datagram, from, 0)) {
      client = from;  // the newest client: one may come back from another port
      arrived(0, datagram);
    }
    while (to_server.receive(datagram, from, 0)) arrived(1, datagram);
    send_due(RelayClock::now());
  }
}

UdpRelay::UdpRelay(const UdpRelayOptions& options) : parts_(std::make_unique<Parts>(options)) {
  parts_->thread = std::thread([this] { parts_->run(); });
}

UdpRelay::~UdpRelay() {
  parts_->stop = true;
  parts_->thread.join();
}

std::uint16_t UdpRelay::port() const { return parts_->to_client.port(); }

UdpRelayCounts UdpRelay::counts() const {
  const std::lock_guard lock(parts_->mutex);
  return parts_->counts;
}

void UdpRelay::set_dark(bool dark) { parts_->dark = dark; }
void UdpRelay::set_delay(double delay_ms) { parts_->delay_ms = delay_ms; }

}  // namespace kt
