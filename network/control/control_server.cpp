#include "network/control/control_server.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>
#include <zmq.hpp>

#include "core/base/error.hpp"
#include "core/base/numbers.hpp"
#include "network/control/endpoint.hpp"
#include "network/control/monitor.hpp"

namespace kt {
namespace {

constexpr int kWaitingIn = 16, kWaitingOut = 256;  // messages a peer
constexpr int kHandshakeMs = 5000;
constexpr std::size_t kMostRefusals = 64;
constexpr int kFailed =
    ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL | ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL | ZMQ_EVENT_HANDSHAKE_FAILED_AUTH;

void check_keys(const ControlServerOptions& options) {
  if (options.own && !(is_curve_key(options.own->public_key) && is_curve_key(options.own->secret_key)))
    throw InputError("control server: its own key is none");
  for (const std::string& key : options.authorized.value_or(std::vector<std::string>{}))
    if (!is_curve_key(key)) throw InputError(text("control server: authorized: ", key, " is no public key"));
  if (options.authorized && !options.own) throw InputError("control server: authorized keys need a key of its own");
}

void set_options(zmq::socket_t& router, const ControlServerOptions& options) {
  router.set(zmq::sockopt::linger, 0);
  router.set(zmq::sockopt::maxmsgsize, static_cast<std::int64_t>(options.most_bytes));
  router.set(zmq::sockopt::rcvhwm, kWaitingIn);
  router.set(zmq::sockopt::sndhwm, kWaitingOut);
  router.set(zmq::sockopt::router_mandatory, true);  // a peer that is gone is told of
  router.set(zmq::sockopt::handshake_ivl, kHandshakeMs);
  router.set(zmq::sockopt::heartbeat_ivl, options.heartbeat_ms);
  router.set(zmq::sockopt::heartbeat_timeout, 3 * options.heartbeat_ms);
  router.set(zmq::sockopt::heartbeat_ttl, 3 * options.heartbeat_ms);
  if (!options.own) return;
  router.set(zmq::sockopt::curve_server, true);
  router.set(zmq::sockopt::curve_secretkey, options.own->secret_key);
  router.set(zmq::sockopt::zap_domain, "kilotouch");
}

std::vector<zmq::message_t> receive_all(zmq::socket_t& socket) {
  std::vector<zmq::message_t> parts;
  do {
    zmq::message_t part;
    if (!socket.recv(part, zmq::recv_flags::dontwait)) break;
    parts.push_back(std::move(part));
  } while (parts.back().more());
  return parts;
}

std::string property(const zmq::message_t& message, const char* name) {
  const char* value = ::zmq_msg_gets(const_cast<zmq::message_t&>(message).handle(), name);
  return value ? value : "";
}

}  // namespace

struct ControlServer::Parts {
  explicit Parts(const ControlServerOptions& o) : options(o), router(context, zmq::socket_type::router) {}

  void answer_zap();
  std::optional<Request> take_request();

  ControlServerOptions options;
  zmq::context_t context;
  std::optional<zmq::socket_t> zap;  ///< whom the context's sockets ask who may connect
  zmq::socket_t router;
  std::optional<ConnectionMonitor> monitor;
  int port = 0;
  std::vector<Refusal> refusals;
  long failed = 0;
};

ControlServer::ControlServer(const ControlServerOptions& options) {
  check_keys(options);
  const Endpoint endpoint = find_endpoint(options.address, options.port);
  parts_ = std::make_unique<Parts>(options);
  Parts& p = *parts_;
  if (options.own) {
    p.zap.emplace(p.context, zmq::socket_type::rep);
    p.zap->set(zmq::sockopt::linger, 0);
    p.zap->bind("inproc://zeromq.zap.01");
  }
  set_options(p.router, options);
  p.monitor.emplace(p.context, p.router, "server-monitor", kFailed);
  if (endpoint.is_six) p.router.set(zmq::sockopt::ipv6, true);
  try {
    p.router.bind(endpoint.text);
  } catch (const zmq::error_t& e) {
    if (e.num() == EADDRINUSE)
      throw InputError(text(endpoint.shown, ": the TCP port is in use; take another, or 0 for any that is free"));
    if (e.num() == EADDRNOTAVAIL || e.num() == ENODEV)
      throw InputError(text(options.address, " is not an address of this computer"));
    throw InputError(text(endpoint.shown, ": cannot listen: ", e.what()));
  }
  const std::string bound = p.router.get(zmq::sockopt::last_endpoint);
  p.port = static_cast<int>(leading_number(std::string_view(bound).substr(bound.rfind(':') + 1)));
}

ControlServer::~ControlServer() = default;

/// One question of ZAP (RFC 27): version, request, domain, address, identity, mechanism, the client's public key; the
/// answer: version, request, status, its text, user, metadata.
void ControlServer::Parts::answer_zap() {
  const std::vector<zmq::message_t> asked = receive_all(*zap);
  if (asked.empty()) return;
  const auto at = [&](std::size_t i) { return i < asked.size() ? asked[i].to_string() : std::string{}; };
  std::array<char, 41> key{};
  const bool is_curve = asked.size() == 7 && at(0) == "1.0" && at(5) == "CURVE" && asked[6].size() == 32;
  if (is_curve) ::zmq_z85_encode(key.data(), static_cast<const std::uint8_t*>(asked[6].data()), asked[6].size());
  const std::string name = key.data();
  const bool known = !options.authorized || std::ranges::find(*options.authorized, name) != options.authorized->end();
  const bool may = is_curve && known;
  if (!may && refusals.size() == kMostRefusals) refusals.erase(refusals.begin());
  if (!may) refusals.push_back({at(3), name});
  const std::array<std::string, 6> answer{"1.0",           at(1), may ? "200" : "400", may ? "OK" : "not authorized",
                                          may ? name : "", ""};
  for (std::size_t i = 0; i < answer.size(); ++i)
    zap->send(zmq::buffer(answer[i]), i + 1 < answer.size() ? zmq::send_flags::sndmore : zmq::send_flags::none);
}

std::optional<ControlServer::Request> ControlServer::Parts::take_request() {
  for (;;) {
    const std::vector<zmq::message_t> got = receive_all(router);
    if (got.empty()) return std::nullopt;
    if (got.size() != 2) continue;  // our clients send one part
    const auto* bytes = static_cast<const std::uint8_t*>(got[1].data());
    return Request{got[0].to_string(),
                   {bytes, bytes + got[1].size()},
                   property(got[1], "Peer-Address"),
                   property(got[1], "User-Id")};
  }
}

std::optional<ControlServer::Request> ControlServer::poll(int timeout_ms) {
  using Clock = std::chrono::steady_clock;
  const auto until = Clock::now() + std::chrono::milliseconds(timeout_ms);
  Parts& p = *parts_;
  std::vector<zmq::pollitem_t> items{{p.router.handle(), 0, ZMQ_POLLIN, 0}, {p.monitor->handle(), 0, ZMQ_POLLIN, 0}};
  if (p.zap) items.push_back({p.zap->handle(), 0, ZMQ_POLLIN, 0});
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now());
    try {
      zmq::poll(items, std::max(left, std::chrono::milliseconds(0)));
      if (p.zap && items[2].revents & ZMQ_POLLIN) p.answer_zap();
      if (items[1].revents & ZMQ_POLLIN) p.monitor->take([&](int, int) { ++p.failed; });
      if (std::optional<Request> request = p.take_request()) return request;
    } catch (const zmq::error_t& e) {
      if (e.num() != EINTR) throw RunError(text("control server: ", e.what()));
      return std::nullopt;  // a signal: the caller may want to stop
    }
    if (Clock::now() >= until) return std::nullopt;
  }
}

bool ControlServer::send(const std::string& peer, std::span<const std::uint8_t> bytes) {
  try {
    zmq::socket_t& router = parts_->router;
    return router.send(zmq::buffer(peer), zmq::send_flags::sndmore | zmq::send_flags::dontwait) &&
           router.send(zmq::buffer(bytes.data(), bytes.size()), zmq::send_flags::dontwait);
  } catch (const zmq::error_t&) {
    return false;  // no such peer, or no more
  }
}

int ControlServer::port() const { return parts_->port; }

std::vector<Refusal> ControlServer::take_refusals() { return std::exchange(parts_->refusals, {}); }

long ControlServer::num_failed_handshakes() const { return parts_->failed; }

}  // namespace kt
