#pragma once
// `kilotouch serve`: a body that one hand at a time touches from another computer.
#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "haptics/setup/built_scene.hpp"
#include "network/body_end.hpp"
#include "network/control/curve_keys.hpp"
#include "network/datagram_port.hpp"

namespace kt {

struct BodyServerOptions {
  std::string address = "127.0.0.1";
  int port = 0;                                          ///< of control (TCP) and datagrams (UDP); 0: any that is free
  std::optional<CurveKey> own{};                         ///< needed beyond loopback
  std::optional<std::vector<std::string>> authorized{};  ///< public keys of hands; none: whoever knows ours
  std::string version{};                                 ///< of the program
  bool once = false;                                     ///< ends with the first hand's session
  const std::atomic<bool>* stop = nullptr;
};

/// What a session of a hand came to.
struct ServedSession {
  std::string peer, reason;  ///< of its end
  bool begun = false;        ///< it got its first local model
  int ticks = 0;
  BodyEndCounts body;
  PortCounts port;
  int wrong_messages = 0;                    ///< datagram or control messages that were none, or out of range
  std::optional<double> loss_up, loss_down;  ///< of datagrams; none: too few came
};

class BodyServer {
 public:
  using Say = std::function<void(const std::string&)>;
  /// @param scene  borrowed: built, link.type network     @param files  that its JSON names, to be sent
  /// @param say    one line a time: connections, refusals
  /// Throws InputError: address or port, or keys that are missing beyond loopback.
  BodyServer(const BuiltScene& scene, std::string scene_json, std::vector<Welcome::File> files,
             const BodyServerOptions& options, Say say);
  ~BodyServer();

  int port() const;
  /// Serves until it is stopped, or, with `once`, the first session is over; each session that ends goes to `ended`.
  void run(const std::function<void(const ServedSession&)>& ended);

  /// The body and the tool as they are now, for a page; false: nobody touches it.
  bool look(VectorX& x, LocalReport& tools, TouchStatus& status) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// Of the body's nodes and connections: both computers have to have the same.
std::uint64_t body_hash(const Body& body);

}  // namespace kt
