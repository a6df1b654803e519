// Sockets and the relay of the tests, on this computer.
#include <gtest/gtest.h>

#include <chrono>

#include "core/base/loopback.hpp"
#include "network/channel/udp_socket.hpp"
#include "network/udp_relay.hpp"
#include "tests/support/input_errors.hpp"

namespace kt {
namespace {

using Bytes = std::vector<std::uint8_t>;
constexpr int kSoonMs = 2000;  // at most; what is there comes at once

TEST(UdpSocket, SendsAndAnswersOverBothFamilies) {
  for (const std::string address : {"127.0.0.1", "::1", "localhost"}) {
    UdpSocket server = UdpSocket::bound(address, 0), client = UdpSocket::connected_to(address, server.port());
    Bytes got;
    Peer from;
    EXPECT_TRUE(client.send(Bytes{1, 2, 3}));
    ASSERT_TRUE(server.receive(got, from, kSoonMs)) << address;
    EXPECT_EQ(got, (Bytes{1, 2, 3}));
    EXPECT_EQ(text_of(from), (address == "::1" ? "[::1]:" : "127.0.0.1:") + std::to_string(client.port()));
    EXPECT_TRUE(server.send(Bytes{}, from));
    ASSERT_TRUE(client.receive(got, from, kSoonMs));
    EXPECT_TRUE(got.empty());
    EXPECT_EQ(from, client.peer());
    EXPECT_FALSE(client.receive(got, from, 0));
  }
}

TEST(UdpSocket, NobodyThereIsNoError) {
  int port = 0;
  { port = UdpSocket::bound("127.0.0.1", 0).port(); }
  UdpSocket client = UdpSocket::connected_to("127.0.0.1", port);
  Bytes got;
  Peer from;
  for (int i = 0; i < 3; ++i) {
    client.send(Bytes{1});
    EXPECT_FALSE(client.receive(got, from, 5));
  }
  client.send(Bytes{1});  // the system tells with the next call that nobody was there
  UdpSocket server = UdpSocket::bound("127.0.0.1", port);
  EXPECT_TRUE(client.send(Bytes{2}));
  ASSERT_TRUE(server.receive(got, from, kSoonMs));
  EXPECT_EQ(got, Bytes{2});
  server = UdpSocket::bound("127.0.0.1", 0);
  client.send(Bytes{3});
  server = UdpSocket::bound("127.0.0.1", port);
  EXPECT_TRUE(server.send(Bytes{4}, from));
  ASSERT_TRUE(client.receive(got, from, kSoonMs));
  EXPECT_EQ(got, Bytes{4});
}

TEST(UdpSocket, WrongAddressesAreSaid) {
  UdpSocket first = UdpSocket::bound("127.0.0.1", 0);
  const std::string port = std::to_string(first.port());
  EXPECT_EQ(message([&] { UdpSocket::bound("127.0.0.1", first.port()); }),
            "127.0.0.1:" + port + ": the UDP port is in use; take another, or 0 for any that is free");
  EXPECT_EQ(message([] { UdpSocket::bound("192.0.2.1", 0); }), "192.0.2.1 is not an address of this computer");
  EXPECT_EQ(message([] { UdpSocket::bound("127.0.0.1", 65536); }), "127.0.0.1: port is 65536; must be in [0, 65535]");
  EXPECT_EQ(message([] { UdpSocket::connected_to("no..name", 1); }).substr(0, 35),
            "no..name: no such address or name: ");
}

TEST(Loopback, IsWhatOnlyThisComputerReaches) {
  for (const char* inside : {"localhost", "127.0.0.1", "127.1.2.3", "::1"}) EXPECT_TRUE(is_loopback(inside)) << inside;
  for (const char* outside : {"", "0.0.0.0", "::", "10.0.0.1", "127.example.org", "192.168.0.1"})
    EXPECT_FALSE(is_loopback(outside)) << outside;
}

struct Ends {
  UdpSocket server = UdpSocket::bound("127.0.0.1", 0);
  UdpRelay relay;
  UdpSocket client;
  explicit Ends(UdpRelayOptions o)
      : relay((o.host_port = server.port(), o)), client(UdpSocket::connected_to("127.0.0.1", relay.port())) {}
};

TEST(UdpRelay, DelaysBothWays) {
  UdpRelayOptions o;
  o.delay_ms = 30;
  Ends ends(o);
  Bytes got;
  Peer from;
  const auto start = std::chrono::steady_clock::now();
  ends.client.send(Bytes{1});
  ASSERT_TRUE(ends.server.receive(got, from, kSoonMs));
  EXPECT_GE(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(30));
  ends.server.send(Bytes{2}, from);
  ASSERT_TRUE(ends.client.receive(got, from, kSoonMs));
  EXPECT_EQ(got, Bytes{2});
  EXPECT_GE(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(60));
}

/// What arrives of 0 .. count - 1, sent one by one.
std::vector<int> arrivals(Ends& ends, int count) {
  std::vector<int> out;
  Bytes got;
  Peer from;
  for (int i = 0; i < count; ++i) {
    ends.client.send(Bytes{static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i >> 8)});
    while (ends.server.receive(got, from, 0)) out.push_back(got[0] + 256 * got[1]);
    while (ends.relay.counts().received[0] <= i && ends.server.receive(got, from, 1))
      out.push_back(got[0] + 256 * got[1]);
  }
  while (ends.server.receive(got, from, 50)) out.push_back(got[0] + 256 * got[1]);
  return out;
}

TEST(UdpRelay, LosesAndDoublesByItsSeed) {
  UdpRelayOptions o;
  o.loss = 0.25;
  o.duplicate = 0.1;
  o.seed = 3;
  std::vector<std::vector<int>> runs;
  for (int run = 0; run < 2; ++run) {
    Ends ends(o);
    std::vector<int> got = arrivals(ends, 400);
    const UdpRelayCounts counts = ends.relay.counts();
    ASSERT_EQ(counts.received[0], 400);
    EXPECT_EQ(static_cast<long>(got.size()), counts.sent[0]);
    EXPECT_EQ(counts.sent[0], 400 - counts.lost[0] + counts.doubled[0]);
    EXPECT_NEAR(static_cast<double>(counts.lost[0]), 100, 35);  // 4 deviations
    EXPECT_NEAR(static_cast<double>(counts.doubled[0]), 30, 21);
    std::sort(got.begin(), got.end());
    runs.push_back(got);
  }
  EXPECT_EQ(runs[0], runs[1]);
}

TEST(UdpRelay, GoesDarkAndComesBack) {
  Ends ends(UdpRelayOptions{});
  EXPECT_EQ(arrivals(ends, 5).size(), 5u);
  ends.relay.set_dark(true);
  EXPECT_EQ(arrivals(ends, 5).size(), 0u);
  ends.relay.set_dark(false);
  EXPECT_EQ(arrivals(ends, 5).size(), 5u);
}

}  // namespace
}  // namespace kt
