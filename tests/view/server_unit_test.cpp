#include "view/server.hpp"

#include <gtest/gtest.h>

#include "core/base/error.hpp"

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
  EXPECT_FALSE(is_own_origin("http://evil.example", "localhost:8080"));
  EXPECT_TRUE(is_own_origin("https://body.example", "body.example"));  // a proxy with TLS before it
  EXPECT_FALSE(is_own_origin("http://localhost:9000", "localhost:8080"));
  EXPECT_FALSE(is_own_origin("https://localhost:8080.evil.example", "localhost:8080"));
  EXPECT_FALSE(is_own_origin("", "localhost:8080"));
  EXPECT_FALSE(is_own_origin("null", "localhost:8080"));
  EXPECT_FALSE(is_own_origin("http://", ""));
}

// A name of others that was pointed at this computer arrives with its own Host header.
TEST(ViewServer, KnowsItsOwnName) {
  const ServerOptions own;
  for (const char* host : {"localhost:8080", "127.0.0.1:8080", "[::1]:8080", "localhost:19000", "localhost", "[::1]"})
    EXPECT_TRUE(is_own_host(host, own)) << host;
  for (const char* host : {"evil.example:8080", "", ":8080", "127.0.0.1.evil.example:8080", "localhost.evil.example"})
    EXPECT_FALSE(is_own_host(host, own)) << host;
  ServerOptions open = own;
  open.address = "0.0.0.0";
  open.token = "open_sesame";
  EXPECT_TRUE(is_own_host("bench.lan:8080", open));
  EXPECT_TRUE(is_own_host("robot3:19000", open));
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
