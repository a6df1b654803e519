#include "network/control/control_client.hpp"

#include <algorithm>
#include <chrono>
#include <zmq.hpp>

#include "core/base/error.hpp"
#include "network/control/endpoint.hpp"
#include "network/control/monitor.hpp"

namespace kt {
namespace {

// Messages. A hand that builds its half takes none meanwhile: were there no room for the server's pings of two minutes,
// its heartbeats would not be read either, and the connection be cut.
constexpr int kClientIn = 256, kClientOut = 256;
constexpr int kClientHandshakeMs = 5000;
constexpr int kAgainFirstMs = 100;
constexpr int kWatched = ZMQ_EVENT_CONNECTED | ZMQ_EVENT_CLOSED | ZMQ_EVENT_DISCONNECTED |
                         ZMQ_EVENT_HANDSHAKE_SUCCEEDED | ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL |
                         ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL | ZMQ_EVENT_HANDSHAKE_FAILED_AUTH;

}  // namespace

struct ControlClient::Parts {
  using Clock = std::chrono::steady_clock;
  explicit Parts(const ControlClientOptions& o) : options(o), dealer(context, zmq::socket_type::dealer) {}

  void set_options();
  void call();
  void call_again(Clock::time_point now);
  void happened(int event);

  ControlClientOptions options;
  zmq::context_t context;
  zmq::socket_t dealer;
  std::string endpoint;
  Clock::time_point called{};
  std::optional<ConnectionMonitor> monitor;
  ClientTrouble trouble = ClientTrouble::not_reached;
  bool shaking = false;  ///< a connection is there, its handshake has not ended
  long connections = 0;
};

void ControlClient::Parts::set_options() {
  dealer.set(zmq::sockopt::linger, 0);
  dealer.set(zmq::sockopt::maxmsgsize, static_cast<std::int64_t>(options.most_bytes));
  dealer.set(zmq::sockopt::rcvhwm, kClientIn);
  dealer.set(zmq::sockopt::sndhwm, kClientOut);
  dealer.set(zmq::sockopt::immediate, true);  // nothing waits for a connection that is not there
  dealer.set(zmq::sockopt::handshake_ivl, kClientHandshakeMs);
  dealer.set(zmq::sockopt::reconnect_ivl, std::min(kAgainFirstMs, options.again_ms));
  dealer.set(zmq::sockopt::reconnect_ivl_max, options.again_ms);
  dealer.set(zmq::sockopt::heartbeat_ivl, options.heartbeat_ms);
  dealer.set(zmq::sockopt::heartbeat_timeout, 3 * options.heartbeat_ms);
  dealer.set(zmq::sockopt::heartbeat_ttl, 3 * options.heartbeat_ms);
  if (!options.server_key) return;
  const CurveKey own = options.own ? *options.own : new_curve_key();
  if (!is_curve_key(*options.server_key)) throw InputError(text(*options.server_key, " is no public key"));
  if (!is_curve_key(own.public_key) || !is_curve_key(own.secret_key))
    throw InputError("control client: its own key is none");
  dealer.set(zmq::sockopt::curve_serverkey, *options.server_key);
  dealer.set(zmq::sockopt::curve_publickey, own.public_key);
  dealer.set(zmq::sockopt::curve_secretkey, own.secret_key);
}

void ControlClient::Parts::call() {
  called = Clock::now();
  dealer.connect(endpoint);
}

/// ZeroMQ gives up an address whose handshake has failed for a reason; but a server may come back with other keys.
void ControlClient::Parts::call_again(Clock::time_point now) {
  if (shaking || trouble == ClientTrouble::none || trouble == ClientTrouble::not_reached) return;
  if (now - called < std::chrono::milliseconds(options.again_ms)) return;
  try {
    dealer.disconnect(endpoint);  // should it try still
  } catch (const zmq::error_t&) {
  }
  call();
}

/// The first word about a connection is the clearest: after it the server hangs up.
void ControlClient::Parts::happened(int event) {
  const auto failed = [&](ClientTrouble how) {
    if (shaking) trouble = how;
    shaking = false;
  };
  switch (event) {
    case ZMQ_EVENT_CONNECTED:
      shaking = true;
      break;
    case ZMQ_EVENT_HANDSHAKE_SUCCEEDED:
      trouble = ClientTrouble::none;
      shaking = false;
      ++connections;
      break;
    case ZMQ_EVENT_HANDSHAKE_FAILED_AUTH:
      failed(ClientTrouble::refused);
      break;
    case ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL:
    case ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL:
      failed(ClientTrouble::handshake_failed);
      break;
    case ZMQ_EVENT_DISCONNECTED:
      if (trouble == ClientTrouble::none) trouble = ClientTrouble::not_reached;
      failed(ClientTrouble::handshake_failed);
      break;
    default:
      trouble = ClientTrouble::not_reached;  // ZMQ_EVENT_CLOSED: nobody there
  }
}

ControlClient::ControlClient(const ControlClientOptions& options) {
  if (options.port < 1) throw InputError(text(options.host, ": port is ", options.port, "; must be in [1, 65535]"));
  const Endpoint endpoint = find_endpoint(options.host, options.port);
  parts_ = std::make_unique<Parts>(options);
  parts_->set_options();
  if (endpoint.is_six) parts_->dealer.set(zmq::sockopt::ipv6, true);
  parts_->monitor.emplace(parts_->context, parts_->dealer, "client-monitor", kWatched);
  parts_->endpoint = endpoint.text;
  try {
    parts_->call();
  } catch (const zmq::error_t& e) {
    throw InputError(text(endpoint.shown, ": ", e.what()));
  }
}

ControlClient::~ControlClient() = default;

bool ControlClient::send(std::span<const std::uint8_t> bytes) {
  try {
    return parts_->dealer.send(zmq::buffer(bytes.data(), bytes.size()), zmq::send_flags::dontwait).has_value();
  } catch (const zmq::error_t&) {
    return false;
  }
}

std::optional<std::vector<std::uint8_t>> ControlClient::poll(int timeout_ms) {
  using Clock = std::chrono::steady_clock;
  const auto until = Clock::now() + std::chrono::milliseconds(timeout_ms);
  Parts& p = *parts_;
  std::vector<zmq::pollitem_t> items{{p.dealer.handle(), 0, ZMQ_POLLIN, 0}, {p.monitor->handle(), 0, ZMQ_POLLIN, 0}};
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now());
    try {
      zmq::poll(items, std::max(left, std::chrono::milliseconds(0)));
      if (items[1].revents & ZMQ_POLLIN) p.monitor->take([&](int event, int) { p.happened(event); });
      p.call_again(Clock::now());
      zmq::message_t message;
      if (p.dealer.recv(message, zmq::recv_flags::dontwait)) {
        bool whole = !message.more();
        const auto* bytes = static_cast<const std::uint8_t*>(message.data());
        std::vector<std::uint8_t> out(bytes, bytes + message.size());
        while (message.more() && p.dealer.recv(message, zmq::recv_flags::dontwait)) whole = false;
        if (whole) return out;  // our server sends one part
        continue;
      }
    } catch (const zmq::error_t& e) {
      if (e.num() != EINTR) throw RunError(text("control client: ", e.what()));
      return std::nullopt;  // a signal: the caller may want to stop
    }
    if (Clock::now() >= until) return std::nullopt;
  }
}

ClientTrouble ControlClient::trouble() const { return parts_->trouble; }

long ControlClient::num_connections() const { return parts_->connections; }

}  // namespace kt
