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

PortCounts& PortCounts::operator+=(const PortCounts& o) {
  opened.opened += o.opened.opened;
  opened.too_short += o.opened.too_short;
  opened.forged += o.opened.forged;
  opened.replayed += o.opened.replayed;
  opened.too_old += o.opened.too_old;
  joined.payloads += o.joined.payloads;
  joined.malformed += o.joined.malformed;
  joined.disagreeing += o.joined.disagreeing;
  joined.repeated += o.joined.repeated;
  joined.surplus += o.joined.surplus;
  joined.old += o.joined.old;
  joined.messages += o.joined.messages;
  joined.recovered += o.joined.recovered;
  joined.given_up += o.joined.given_up;
  bytes_sent += o.bytes_sent;
  bytes_received += o.bytes_received;
  sent += o.sent;
  return *this;
}

DatagramPort::DatagramPort(UdpSocket socket, const SealKey& key, Direction sends)
    : socket_(std::move(socket)),
      sealer_(key, static_cast<std::uint8_t>(sends)),
      opener_(key, static_cast<std::uint8_t>(other(sends))),
      peer_(socket_.peer()) {}

std::vector<std::vector<std::uint8_t>> DatagramPort::payloads(DatagramKind kind, Bytes bytes, double loss) {
  const auto k = static_cast<std::uint8_t>(kind);
  return split({k, next_number_[k % kNumKinds]++, std::move(bytes)}, loss);
}

void DatagramPort::send(DatagramKind kind, Bytes bytes, double loss) {
  sender_.put(payloads(kind, std::move(bytes), loss), true, static_cast<std::uint8_t>(kind));
  pump(std::chrono::steady_clock::now());
}

/// Begins to: poll() does the rest.
void DatagramPort::spread(DatagramKind kind, Bytes bytes, double loss, double seconds, double limit) {
  auto all = payloads(kind, std::move(bytes), loss);
  sender_.set_pace(pace_for(all.size(), seconds, limit));
  sender_.put(std::move(all), false, static_cast<std::uint8_t>(kind));
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
