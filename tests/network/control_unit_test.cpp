// Both ends of the control channel in one process: messages, keys, and what is said when there is no connection.
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>

#include "network/control/control_client.hpp"
#include "network/control/control_server.hpp"
#include "tests/support/input_errors.hpp"

namespace kt {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes bytes_of(const std::string& text) { return {text.begin(), text.end()}; }

/// Server and client take turns in one thread.
struct Ends {
  ControlServer server;
  std::unique_ptr<ControlClient> client;
  std::vector<ControlServer::Request> requests;
  std::vector<Bytes> answers;

  explicit Ends(const ControlServerOptions& s = {}, ControlClientOptions c = {}) : server(s) { call(c); }

  void call(ControlClientOptions c = {}) {
    c.port = server.port();
    client = std::make_unique<ControlClient>(c);
  }
  /// Until it is so, at most 5 s.
  bool until(const std::function<bool()>& is_so) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(5);
    while (std::chrono::steady_clock::now() < end) {
      if (is_so()) return true;
      if (auto request = server.poll(1)) requests.push_back(std::move(*request));
      if (auto answer = client->poll(1)) answers.push_back(std::move(*answer));
    }
    return is_so();
  }
  bool until_connected() {
    return until([&] { return client->trouble() == ClientTrouble::none; });
  }
};

struct Keys {
  CurveKey server = new_curve_key(), client = new_curve_key();
  ControlServerOptions server_options() const {
    ControlServerOptions o;
    o.own = server;
    o.authorized = {client.public_key};
    return o;
  }
  ControlClientOptions client_options() const {
    ControlClientOptions o;
    o.own = client;
    o.server_key = server.public_key;
    return o;
  }
};

void exchange(Ends& ends, const std::string& key) {
  ASSERT_TRUE(ends.until_connected());
  EXPECT_EQ(ends.client->num_connections(), 1);
  ASSERT_TRUE(ends.client->send(bytes_of("hello")));
  ASSERT_TRUE(ends.until([&] { return ends.requests.size() == 1; }));
  EXPECT_EQ(ends.requests[0].bytes, bytes_of("hello"));
  EXPECT_EQ(ends.requests[0].key, key);
  EXPECT_EQ(ends.requests[0].address, "127.0.0.1");
  Bytes mesh(5 << 20);
  for (std::size_t i = 0; i < mesh.size(); ++i) mesh[i] = static_cast<std::uint8_t>(i * 7 >> 3);
  for (int i = 0; i < 10; ++i)
    EXPECT_TRUE(ends.server.send(ends.requests[0].peer, Bytes{static_cast<std::uint8_t>(i)}));
  EXPECT_TRUE(ends.server.send(ends.requests[0].peer, mesh));
  EXPECT_TRUE(ends.server.send(ends.requests[0].peer, {}));
  ASSERT_TRUE(ends.until([&] { return ends.answers.size() == 12; }));
  for (std::size_t i = 0; i < 10; ++i) EXPECT_EQ(ends.answers[i], Bytes{static_cast<std::uint8_t>(i)});
  EXPECT_EQ(ends.answers[10], mesh);
  EXPECT_TRUE(ends.answers[11].empty());
}

TEST(Control, WithoutKeys) {
  Ends ends;
  exchange(ends, "");
}

TEST(Control, OverSix) {
  ControlServerOptions s;
  s.address = "::1";
  ControlClientOptions c;
  c.host = "::1";
  Ends ends(s, c);
  EXPECT_TRUE(ends.until_connected());
}

TEST(Control, WithKeysOfBothSides) {
  const Keys keys;
  Ends ends(keys.server_options(), keys.client_options());
  exchange(ends, keys.client.public_key);
  EXPECT_EQ(ends.server.num_failed_handshakes(), 0);
  EXPECT_TRUE(ends.server.take_refusals().empty());
}

TEST(Control, WithoutAListWhoeverKnowsTheServersKey) {
  const Keys keys;
  ControlServerOptions s = keys.server_options();
  s.authorized.reset();
  ControlClientOptions c = keys.client_options();
  c.own.reset();
  Ends ends(s, c);
  EXPECT_TRUE(ends.until_connected());
}

TEST(Control, AKeyThatIsNotOnTheListIsRefusedAndSaid) {
  const Keys keys;
  ControlClientOptions c = keys.client_options();
  const CurveKey stranger = new_curve_key();
  c.own = stranger;
  c.again_ms = 50;
  Ends ends(keys.server_options(), c);
  ASSERT_TRUE(ends.until([&] { return ends.client->trouble() == ClientTrouble::refused; }));
  const std::vector<Refusal> refusals = ends.server.take_refusals();
  ASSERT_FALSE(refusals.empty());
  EXPECT_EQ(refusals[0].key, stranger.public_key);
  EXPECT_EQ(refusals[0].address, "127.0.0.1");
  EXPECT_FALSE(ends.client->send(bytes_of("let me in")));
  EXPECT_TRUE(ends.until([&] { return ends.server.take_refusals().size() > 0; }));  // it tries again, and stays refused
  EXPECT_NE(ends.client->trouble(), ClientTrouble::none);
  EXPECT_TRUE(ends.requests.empty());
  ends.call(keys.client_options());  // the right one, beside
  EXPECT_TRUE(ends.until_connected());
}

TEST(Control, AnotherServerKeyIsToldFromNoServer) {
  const Keys keys;
  ControlClientOptions c = keys.client_options();
  c.server_key = new_curve_key().public_key;
  Ends ends(keys.server_options(), c);
  EXPECT_TRUE(ends.until([&] { return ends.client->trouble() == ClientTrouble::handshake_failed; }));
  EXPECT_FALSE(ends.client->send(bytes_of("hello")));
  EXPECT_TRUE(ends.until([&] { return ends.server.num_failed_handshakes() > 0; }));
  EXPECT_TRUE(ends.requests.empty());
}

TEST(Control, KeysOnOneSideAloneDoNotConnect) {
  const Keys keys;
  Ends without(keys.server_options(), {});
  EXPECT_TRUE(without.until([&] { return without.client->trouble() == ClientTrouble::handshake_failed; }));
  EXPECT_FALSE(without.client->send(bytes_of("hello")));
  Ends with({}, keys.client_options());
  EXPECT_TRUE(with.until([&] { return with.client->trouble() == ClientTrouble::handshake_failed; }));
  EXPECT_TRUE(without.requests.empty());
}

TEST(Control, TheServerMayComeLateDieAndComeBack) {
  ControlServerOptions s;
  {
    const ControlServer first(s);
    s.port = first.port();
  }
  ControlClientOptions c;
  c.port = s.port;
  ControlClient client(c);
  EXPECT_FALSE(client.poll(30));
  EXPECT_EQ(client.trouble(), ClientTrouble::not_reached);
  EXPECT_FALSE(client.send(bytes_of("nobody")));
  for (long time = 1; time <= 2; ++time) {
    ControlServer server(s);
    for (int i = 0; i < 3000 && client.num_connections() < time; ++i) {
      server.poll(0);
      client.poll(1);
    }
    ASSERT_EQ(client.trouble(), ClientTrouble::none);
    EXPECT_EQ(client.num_connections(), time);
    EXPECT_TRUE(client.send(bytes_of("here")));
    const auto request = server.poll(2000);
    ASSERT_TRUE(request);
    EXPECT_EQ(request->bytes, bytes_of("here"));
  }
  for (int i = 0; i < 3000 && client.trouble() == ClientTrouble::none; ++i) client.poll(1);
  EXPECT_EQ(client.trouble(), ClientTrouble::not_reached);
}

/// Takes connections at the port and never says a word.
class SilentServer {
 public:
  explicit SilentServer(int port) : descriptor_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const int on = 1;
    ::setsockopt(descriptor_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    is_there = ::bind(descriptor_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
               ::listen(descriptor_, 5) == 0;
  }
  ~SilentServer() { ::close(descriptor_); }
  bool is_there = false;

 private:
  int descriptor_;
};

TEST(Control, AServerThatIsGoneIsToldAtOnceWhateverTakesItsPlace) {
  auto server = std::make_unique<ControlServer>(ControlServerOptions{});
  ControlClientOptions c;
  c.port = server->port();
  ControlClient client(c);
  for (int i = 0; i < 3000 && client.trouble() != ClientTrouble::none; ++i) {
    server->poll(0);
    client.poll(1);
  }
  ASSERT_EQ(client.trouble(), ClientTrouble::none);
  server.reset();
  const SilentServer silent(c.port);
  ASSERT_TRUE(silent.is_there);
  for (int i = 0; i < 1000 && client.trouble() == ClientTrouble::none; ++i) client.poll(1);
  EXPECT_EQ(client.trouble(), ClientTrouble::not_reached);
}

TEST(Control, AServerThatComesBackWithAnotherListLetsIn) {
  const Keys keys;
  ControlServerOptions s = keys.server_options();
  s.authorized = std::vector<std::string>{};
  auto server = std::make_unique<ControlServer>(s);
  s.port = server->port();
  ControlClientOptions c = keys.client_options();
  c.port = s.port;
  c.again_ms = 50;
  ControlClient client(c);
  const auto turn = [&](ClientTrouble wanted) {
    for (int i = 0; i < 3000 && client.trouble() != wanted; ++i) {
      server->poll(1);
      client.poll(1);
    }
    return client.trouble() == wanted;
  };
  ASSERT_TRUE(turn(ClientTrouble::refused));
  server.reset();
  s.authorized = {keys.client.public_key};
  server = std::make_unique<ControlServer>(s);
  EXPECT_TRUE(turn(ClientTrouble::none));
  EXPECT_EQ(client.num_connections(), 1);
}

TEST(Control, AClientThatIsGoneTakesNothing) {
  Ends ends;
  ASSERT_TRUE(ends.until_connected());
  ASSERT_TRUE(ends.client->send(bytes_of("hello")));
  ASSERT_TRUE(ends.until([&] { return !ends.requests.empty(); }));
  const std::string peer = ends.requests[0].peer;
  EXPECT_FALSE(ends.server.send("nobody", bytes_of("x")));
  EXPECT_TRUE(ends.server.send(peer, bytes_of("x")));
  ends.call();
  EXPECT_TRUE(ends.until([&] { return !ends.server.send(peer, bytes_of("x")); }));
}

TEST(Control, TooLargeAMessageCutsTheClientOff) {
  ControlServerOptions s;
  s.most_bytes = 1000;
  Ends ends(s);
  ASSERT_TRUE(ends.until_connected());
  EXPECT_TRUE(ends.client->send(Bytes(1000)));
  ASSERT_TRUE(ends.until([&] { return ends.requests.size() == 1; }));
  EXPECT_TRUE(ends.client->send(Bytes(1001)));
  EXPECT_TRUE(ends.until([&] { return ends.client->num_connections() > 1; }));  // cut off, and called again
  EXPECT_EQ(ends.requests.size(), 1u);
}

TEST(Control, WrongOptionsAreSaid) {
  ControlServer first{ControlServerOptions{}};
  ControlServerOptions s;
  s.port = first.port();
  EXPECT_EQ(
      message([&] { ControlServer second(s); }),
      "127.0.0.1:" + std::to_string(s.port) + ": the TCP port is in use; take another, or 0 for any that is free");
  s = {};
  s.address = "192.0.2.1";
  EXPECT_EQ(message([&] { ControlServer second(s); }), "192.0.2.1 is not an address of this computer");
  s = {};
  s.authorized = std::vector<std::string>{};
  EXPECT_NE(message([&] { ControlServer second(s); }), "no InputError");
  s.own = CurveKey{"a", "b"};
  EXPECT_NE(message([&] { ControlServer second(s); }), "no InputError");
  ControlClientOptions c;
  EXPECT_NE(message([&] { ControlClient client(c); }).find("port is 0"), std::string::npos);
  c.port = 1;
  c.host = "no..name";
  EXPECT_NE(message([&] { ControlClient client(c); }).find("no such address or name"), std::string::npos);
  c.host = "127.0.0.1";
  c.server_key = "short";
  EXPECT_EQ(message([&] { ControlClient client(c); }), "short is no public key");
}

}  // namespace
}  // namespace kt
