#include "network/datagram_port.hpp"

#include <poll.h>

#include <algorithm>

namespace kt {
namespace {

Direction other(Direction d) { return d == Direction::to_body ? Direction::to_hand : Direction::to_body; }

bool wait_for(int descriptor, std::chrono::microseconds timeout) {
  pollfd one{descriptor, POLLIN, 0};
  const timespec t{timeout.count() / 1000000, timeout.count() % 1000000 * 1000};
  return ppoll(&one, 1, &t, nullptr) > 0;
}

}  // namespace

DatagramPort::DatagramPort(UdpSocket socket, const SealKey& key, Direction sends)
    : socket_(std::move(socket)),
      sealer_(key, static_cast<std::uint8_t>(sends)),
      opener_(key, static_cast<std::uint8_t>(other(sends))),
      peer_(socket_.peer()) {}

void DatagramPort::send(DatagramKind kind, Bytes bytes, double loss, bool urgent) {
  const auto k = static_cast<std::uint8_t>(kind);
  Message message{k, next_number_[k % kNumKinds]++, std::move(bytes)};
  sender_.put(split(message, loss), urgent, k);
  pump(std::chrono::steady_clock::now());
}

void DatagramPort::pump(std::chrono::steady_clock::time_point now) {
  if (!has_peer()) return;  // nobody is there yet
  due_ = sender_.pump(now, [&](std::span<const std::uint8_t> payload) {
    sealer_.seal(payload, datagram_);
    socket_.send(datagram_, peer_);
    counts_.bytes_sent += static_cast<long long>(datagram_.size());
    ++counts_.sent;
  });
}

std::optional<Message> DatagramPort::poll(std::chrono::microseconds timeout) {
  const auto end = std::chrono::steady_clock::now() + timeout;
  for (;;) {
    Peer from;
    while (socket_.receive(datagram_, from, 0)) {
      if (!opener_.open(datagram_, payload_)) continue;
      counts_.bytes_received += static_cast<long long>(datagram_.size());
      peer_ = from;
      heard_ = std::chrono::steady_clock::now();
      if (auto message = joiner_.take(payload_)) return message;
    }
    const auto now = std::chrono::steady_clock::now();
    pump(now);
    const auto left = std::chrono::duration_cast<std::chrono::microseconds>(end - now);
    if (left.count() <= 0) return {};
    wait_for(socket_.descriptor(), due_ ? std::min(std::max(*due_, std::chrono::microseconds(50)), left) : left);
  }
}

PortCounts DatagramPort::counts() const {
  PortCounts out = counts_;
  out.opened = opener_.counts();
  out.joined = joiner_.counts();
  return out;
}

}  // namespace kt
