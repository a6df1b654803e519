#pragma once
// The control channel's listening end: few messages, whole and in order (ZeroMQ ROUTER over TCP), with keys sealed and
// authenticated both ways (CURVE, ZeroMQ RFC 26; who may connect: ZAP, RFC 27).
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "network/control/curve_keys.hpp"

namespace kt {

struct ControlServerOptions {
  std::string address = "127.0.0.1";                     ///< of this computer, IPv4 or IPv6
  int port = 0;                                          ///< 0: any that is free
  std::optional<CurveKey> own{};                         ///< none: whoever reaches the port may connect
  std::optional<std::vector<std::string>> authorized{};  ///< public keys; none: whoever knows own.public_key
  std::size_t most_bytes = std::size_t{1} << 20;         ///< of an incoming message; who sends more is cut off
  int heartbeat_ms = 1000;                               ///< a peer that answers none for three of these is cut off
};

/// Who tried to connect and may not.
struct Refusal {
  std::string address, key;  ///< public key
};

/// To be used by one thread. Handshakes go on inside poll().
class ControlServer {
 public:
  /// Listens. Throws InputError: port in use, not an address of this computer, not a key.
  explicit ControlServer(const ControlServerOptions& options);
  ~ControlServer();

  struct Request {
    std::string peer;  ///< bytes, for send(); another one after each time that the peer connects
    std::vector<std::uint8_t> bytes;
    std::string address, key;  ///< the peer's; key empty without keys
  };
  /// The next message.
  /// @param timeout_ms  0: does not wait
  std::optional<Request> poll(int timeout_ms);

  /// @returns false: the peer is gone, or has taken none of the last messages
  bool send(const std::string& peer, std::span<const std::uint8_t> bytes);

  int port() const;
  std::vector<Refusal> take_refusals();  ///< the last of them, at most 64, since the last call
  long num_failed_handshakes() const;    ///< wrong server key, no keys, other protocols; those not authorized too

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace kt
