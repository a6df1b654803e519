#pragma once
// A bad network on one computer: a UDP relay that delays, loses, doubles and reorders datagrams, from a seed.
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

namespace kt {

struct UdpRelayOptions {
  std::string address = "127.0.0.1";  ///< listens here, for one client
  int port = 0;                       ///< 0: any that is free
  std::string host = "127.0.0.1";     ///< the server
  int host_port = 0;
  double delay_ms = 0;                          ///< each way
  double jitter_ms = 0;                         ///< evenly in [0, jitter] more; what it lets overtake arrives so
  double loss = 0, duplicate = 0, reorder = 0;  ///< shares of the datagrams; reordered ones come kReorderMs later
  double rate_mbit = 0;                         ///< each way, with a queue of 100 ms; 0: no limit
  std::uint64_t seed = 1;
};

/// Of one way: [0] from the client, [1] from the server.
struct UdpRelayCounts {
  std::array<long, 2> received{}, lost{}, doubled{}, reordered{}, overflown{}, sent{};
  std::array<long, 2> bytes{};  ///< received
};

/// Runs in a thread of its own until it is destroyed.
class UdpRelay {
 public:
  static constexpr double kReorderMs = 5, kQueueMs = 100;

  /// Throws InputError: port in use, no such server.
  explicit UdpRelay(const UdpRelayOptions& options);
  ~UdpRelay();

  std::uint16_t port() const;
  UdpRelayCounts counts() const;
  void set_dark(bool dark);         ///< dark: everything that arrives is lost
  void set_delay(double delay_ms);  ///< from now on

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace kt
