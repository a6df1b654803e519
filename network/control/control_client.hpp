#pragma once
// The control channel's calling end (ZeroMQ DEALER); it connects again by itself when the connection is lost.
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "network/control/curve_keys.hpp"

namespace kt {

struct ControlClientOptions {
  std::string host = "127.0.0.1";
  int port = 0;
  std::optional<CurveKey> own{};            ///< with server_key; none and server_key given: a new one, for this time
  std::optional<std::string> server_key{};  ///< public key of the server; none: no keys
  std::size_t most_bytes = std::size_t{64} << 20;  ///< of an incoming message
  int again_ms = 1000;      ///< at most so long after a connection was lost or refused it calls again
  int heartbeat_ms = 1000;  ///< a server that answers none for three of these is taken for gone
};

enum class ClientTrouble {
  none,              ///< connected
  not_reached,       ///< nobody there, or not yet, or no more
  refused,           ///< the server does not know this key
  handshake_failed,  ///< another server key, only one side has keys, or no server of ours
};

/// To be used by one thread.
class ControlClient {
 public:
  /// Begins to connect. Throws InputError: host, port or key is none.
  explicit ControlClient(const ControlClientOptions& options);
  ~ControlClient();

  /// @returns false: not connected, or the last messages wait still
  bool send(std::span<const std::uint8_t> bytes);

  /// The next message.
  /// @param timeout_ms  0: does not wait
  std::optional<std::vector<std::uint8_t>> poll(int timeout_ms);

  /// As of the last poll().
  ClientTrouble trouble() const;
  long num_connections() const;  ///< made so far: one more each time that it has come back

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace kt
