#pragma once
// The hand's way to a body on another computer: who is there, what scene it has, and the key of its datagrams.
#include <atomic>
#include <functional>
#include <memory>

#include "core/base/error.hpp"
#include "network/control/control_client.hpp"
#include "network/datagram_port.hpp"

namespace kt {

struct HandConnectionOptions {
  std::string host = "127.0.0.1";
  int port = 0;
  int data_port = 0;                        ///< of datagrams; 0: as the server says. Others go through a relay
  std::string data_host{};                  ///< empty: `host`
  std::optional<CurveKey> own{};            ///< with server_key
  std::optional<std::string> server_key{};  ///< needed beyond loopback
  std::string version{};                    ///< of the program
  double wait = 30;                         ///< [s] for a server that is not there, or has gone
  const std::atomic<bool>* stop = nullptr;
};

/// To be used by one thread at a time.
class HandConnection {
 public:
  /// Throws InputError: host, port or keys.
  explicit HandConnection(const HandConnectionOptions& options);

  /// Asks until the server is there and has time, or it has been waited for. Throws InputError: refused, another
  /// version; RunError: nobody came, somebody else has the body all the time, or the program is stopped.
  /// @param say  one line, where it takes longer
  Welcome greet(const std::function<void(const std::string&)>& say);

  /// The first local model; none: the server has gone since it was greeted. Throws RunError: it says no, or nothing for
  /// `kPatience`.
  std::optional<ModelMessage> begin(const Begin& message);

  /// Datagrams of the session that was greeted last.
  std::unique_ptr<DatagramPort> open_port(const Welcome& welcome) const;

  /// Greets a server that is there and was not greeted since: its Welcome comes by poll().
  /// @param session  that was lost; 0: none
  void ask(std::uint64_t session = 0);
  /// It is to be greeted once more.
  void ask_again() { asked_ = 0; }
  bool send(const ControlMessage& message);
  std::optional<ControlMessage> poll(int timeout_ms);
  ClientTrouble trouble() const { return control_->trouble(); }
  /// Of the control channel, and of the datagrams of a session: "192.168.1.20:7700".
  std::string place() const { return text(options_.host, ":", options_.port); }
  std::string data_place(const Welcome& welcome) const { return text(data_host(), ":", data_port(welcome)); }
  const HandConnectionOptions& options() const { return options_; }
  int wrong_messages() const { return wrong_; }

 private:
  std::optional<Welcome> try_again();
  const std::string& data_host() const { return options_.data_host.empty() ? options_.host : options_.data_host; }
  int data_port(const Welcome& welcome) const { return options_.data_port > 0 ? options_.data_port : welcome.port; }
  void throw_if_refused() const;
  HandConnectionOptions options_;
  std::unique_ptr<ControlClient> control_;
  long asked_ = 0;       // number of the connection over which the server was greeted
  std::string put_off_;  // why it is to be asked again later
  int wrong_ = 0;
};

}  // namespace kt
