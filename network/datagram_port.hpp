#pragma once
// Messages in and out as sealed datagrams. To be used by one thread.
#include <chrono>
#include <optional>

#include "network/channel/paced_sender.hpp"
#include "network/channel/sealed.hpp"
#include "network/channel/shards.hpp"
#include "network/channel/udp_socket.hpp"
#include "network/message/messages.hpp"

namespace kt {

/// Which way a datagram goes: part of its seal.
enum class Direction : std::uint8_t { to_body = 1, to_hand = 2 };

struct PortCounts {
  OpenCounts opened{};
  JoinerCounts joined{};
  long long bytes_sent = 0, bytes_received = 0;
  long sent = 0;  ///< datagrams
  PortCounts& operator+=(const PortCounts& other);
};

class DatagramPort {
 public:
  /// @param sends  the other direction is what it receives
  DatagramPort(UdpSocket socket, const SealKey& key, Direction sends);

  /// At once.
  /// @param loss  what parity is for; below 0: none
  void send(DatagramKind kind, Bytes bytes, double loss);
  /// The same spread over a time, after what is urgent; replaces one of its kind that is on its way still.
  /// @param limit  datagrams a second, no more
  void spread(DatagramKind kind, Bytes bytes, double loss, double seconds, double limit);
  bool is_spreading(DatagramKind kind) const { return sender_.is_sending(static_cast<std::uint8_t>(kind)); }

  /// Sends what is due and waits for a message, but no longer than that.
  std::optional<Message> poll(std::chrono::microseconds timeout);

  std::optional<double> loss() const { return opener_.loss(); }  ///< of incoming datagrams; none: not known yet
  bool has_peer() const { return peer_.size != 0; }
  const Peer& peer() const { return peer_; }
  /// When the last datagram came that was no forgery.
  std::chrono::steady_clock::time_point heard() const { return heard_; }
  Feedback feedback() const { return opener_.feedback(); }  ///< of incoming datagrams
  std::uint64_t num_sealed() const { return sealer_.num_sealed(); }
  PortCounts counts() const;

 private:
  std::vector<std::vector<std::uint8_t>> payloads(DatagramKind kind, Bytes bytes, double loss);
  void pump(std::chrono::steady_clock::time_point now);
  UdpSocket socket_;
  Sealer sealer_;
  Opener opener_;
  ShardJoiner joiner_;
  PacedSender sender_;
  Peer peer_;  // the other side: of the last datagram that could be opened
  std::optional<std::chrono::microseconds> due_;
  std::array<std::uint32_t, kNumKinds> next_number_{};
  std::vector<std::uint8_t> datagram_, payload_;
  std::chrono::steady_clock::time_point heard_{};
  PortCounts counts_;
};

}  // namespace kt
