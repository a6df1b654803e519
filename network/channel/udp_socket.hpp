#pragma once
// A UDP socket, IPv4 or IPv6. What a network does to datagrams (lost, late, nobody there) is no error here.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace kt {

/// Where a datagram came from, or goes to: address and port.
struct Peer {
  std::array<std::uint8_t, 28> bytes{};  ///< a sockaddr_in or sockaddr_in6
  std::uint32_t size = 0;                ///< 0: none
  bool operator==(const Peer&) const = default;
};

/// "127.0.0.1:7000", "[::1]:7000"
std::string text_of(const Peer& peer);

/// An address or name. Of a name's addresses an IPv4 one is taken first, as the control channel does.
/// Throws InputError: not known, port outside 0 to 65535.
Peer find_peer(const std::string& host, int port);

class UdpSocket {
 public:
  /// Receives what comes to the address. Throws InputError: in use, not an address of this computer.
  /// @param port  0: any that is free
  static UdpSocket bound(const std::string& address, int port);

  /// Sends to one peer and receives from that one alone. Throws InputError: name not known, no way there.
  static UdpSocket connected_to(const std::string& host, int port);

  UdpSocket(UdpSocket&& other) noexcept;
  UdpSocket& operator=(UdpSocket&& other) noexcept;
  ~UdpSocket();

  /// Waits for a datagram; longer ones than kMostDatagram are cut.
  /// @param timeout_ms  0: does not wait
  /// @param datagram    replaced
  /// @returns false: none came
  bool receive(std::vector<std::uint8_t>& datagram, Peer& from, int timeout_ms);

  /// @returns false: it did not leave this computer (no room to send, no way there): as good as lost
  bool send(std::span<const std::uint8_t> datagram, const Peer& to);
  bool send(std::span<const std::uint8_t> datagram);  ///< to the peer connected to

  std::uint16_t port() const;                     ///< our own
  Peer peer() const;                              ///< connected to
  int descriptor() const { return descriptor_; }  ///< for poll(2)

  static constexpr std::size_t kMostDatagram = 2048;

 private:
  explicit UdpSocket(int descriptor) : descriptor_(descriptor) {}
  int descriptor_ = -1;
};

}  // namespace kt
