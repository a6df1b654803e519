#include "view/server/server.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <utility>

#include "core/base/error.hpp"
#include "view/server/peer_user.hpp"

namespace kt {
namespace {

class Nobody final : public ServerHandler {
 public:
  void joined(int) override {}
  void received(int, const std::string&) override {}
  void left(int) override {}
  std::string uploaded(const std::string&, const std::string&) override { return "{}"; }
  void tick() override {}
};

TEST(ViewServer, SpeaksToItsOwnPagesOnly) {
  EXPECT_TRUE(is_own_origin("http://localhost:8080", "localhost:8080"));
  EXPECT_TRUE(is_own_origin("https://bench.lan", "bench.lan"));  // carried on by a server that has a certificate
  EXPECT_FALSE(is_own_origin("http://evil.example", "localhost:8080"));
  EXPECT_FALSE(is_own_origin("http://localhost:3000", "localhost:8080"));
  EXPECT_FALSE(is_own_origin("", "localhost:8080"));
  EXPECT_FALSE(is_own_origin("null", "localhost:8080"));
  EXPECT_FALSE(is_own_origin("http://", ""));
}

// A name of others that was pointed at this computer arrives with its own Host header.
TEST(ViewServer, KnowsItsOwnName) {
  ServerOptions own;
  for (const char* host : {"localhost:8080", "127.0.0.1:8080", "[::1]:8080", "localhost:19000", "localhost"})
    EXPECT_TRUE(is_own_host(host, own)) << host;
  for (const char* host : {"evil.example:8080", "evil.example", "", ":8080", "127.0.0.1.evil.example:8080",
                           "localhost.evil.example", "localhost:x", "localhost:", "localhost:123456"})
    EXPECT_FALSE(is_own_host(host, own)) << host;
  own.token = "open_sesame";  // who rebinds a name does not have it
  EXPECT_TRUE(is_own_host("bench.lan:8080", own));
  EXPECT_TRUE(is_own_host("bench.lan", own));
  EXPECT_FALSE(is_own_host("", own));
}

/// A connection to oneself over 127.0.0.1.
class OwnConnection {
 public:
  OwnConnection() {
    listener_ = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in here{};
    here.sin_family = AF_INET;
    here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    bind(listener_, reinterpret_cast<sockaddr*>(&here), sizeof here);
    listen(listener_, 1);
    server_port = port_of(listener_);
    here.sin_port = htons(server_port);
    client_ = socket(AF_INET, SOCK_STREAM, 0);
    connect(client_, reinterpret_cast<sockaddr*>(&here), sizeof here);
    client_port = port_of(client_);
  }
  ~OwnConnection() {
    close_client();
    close(listener_);
  }
  OwnConnection(const OwnConnection&) = delete;
  void close_client() {
    if (client_ >= 0) close(std::exchange(client_, -1));
  }
  unsigned short server_port = 0, client_port = 0;

 private:
  static unsigned short port_of(int descriptor) {
    sockaddr_in at{};
    socklen_t size = sizeof at;
    getsockname(descriptor, reinterpret_cast<sockaddr*>(&at), &size);
    return ntohs(at.sin_port);
  }
  int listener_ = -1, client_ = -1;
};

// Another user's end: tests/apps/view_doors_unit_test.py.
TEST(ViewServer, KnowsWhoseTheOtherEndIs) {
  OwnConnection own;
  EXPECT_TRUE(is_peer_of_this_user("127.0.0.1", own.client_port, own.server_port));
  EXPECT_FALSE(is_peer_of_this_user("127.0.0.2", own.client_port, own.server_port));
  EXPECT_FALSE(is_peer_of_this_user("192.0.2.1", own.client_port, own.server_port));
  EXPECT_FALSE(is_peer_of_this_user("nowhere", own.client_port, own.server_port));
  EXPECT_FALSE(is_peer_of_this_user("127.0.0.1", own.server_port, own.client_port == 1 ? 2 : 1));
  own.close_client();  // the kernel tells no user of it any more
  EXPECT_FALSE(is_peer_of_this_user("127.0.0.1", own.client_port, own.server_port));
}

TEST(ViewServer, ComparesSecrets) {
  EXPECT_TRUE(is_same_secret("abcdefgh", "abcdefgh"));
  for (const char* other : {"", "abcdefg", "abcdefgi", "abcdefghi", "Abcdefgh"})
    EXPECT_FALSE(is_same_secret(other, "abcdefgh")) << other;
}

TEST(ViewServer, RefusesAnAddressOfOthersWithoutToken) {
  Nobody nobody;
  EXPECT_THROW(Server({"0.0.0.0", 0, ""}, nobody), InputError);
  EXPECT_THROW(Server({"0.0.0.0", 0, "short"}, nobody), InputError);
  EXPECT_THROW(Server({"nowhere", 0, "long_enough"}, nobody), InputError);
  Server first({"127.0.0.1", 0, ""}, nobody);
  try {
    Server second({"127.0.0.1", first.port(), ""}, nobody);
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("in use"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace kt
