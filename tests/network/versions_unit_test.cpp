// What a server says to a hand of another version, and to one that talks nonsense.
#include <gtest/gtest.h>

#include <thread>

#include "network/body_server.hpp"
#include "network/control/control_client.hpp"
#include "network/hand_connection.hpp"
#include "tests/support/haptics_scene.hpp"
#include "tests/support/input_errors.hpp"

namespace kt {
namespace {

/// A server in a thread of its own.
class RunningServer {
 public:
  RunningServer()
      : built_(scene()),
        server_(built_, "{}", {}, options(), [this](const std::string& line) { said_.push_back(line); }),
        thread_([this] { server_.run({}); }) {}
  ~RunningServer() { end(); }
  int port() const { return server_.port(); }
  const std::vector<std::string>& end() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    return said_;
  }

 private:
  static Scene scene() {
    Scene out = small_scene();
    out.link.type = "network";
    return out;
  }
  BodyServerOptions options() const {
    BodyServerOptions out;
    out.version = "1.2.3";
    out.stop = &stop_;
    return out;
  }
  std::atomic<bool> stop_{false};
  BuiltScene built_;
  std::vector<std::string> said_;
  BodyServer server_;
  std::thread thread_;
};

/// What the server answers to a first message, within 5 s.
std::optional<ControlMessage> answer(int port, std::span<const std::uint8_t> first) {
  ControlClientOptions options;
  options.port = port;
  ControlClient client(options);
  bool is_sent = false;
  for (int i = 0; i < 500; ++i) {
    const auto bytes = client.poll(10);
    if (bytes) return decode_control(*bytes);
    if (!is_sent && client.trouble() == ClientTrouble::none) is_sent = client.send(first);
  }
  return {};
}

std::string refusal(int port, const Hello& hello) {
  const auto message = answer(port, encode(ControlMessage(hello)));
  const Bye* bye = message ? std::get_if<Bye>(&*message) : nullptr;
  return bye ? bye->reason : "not refused";
}

TEST(Versions, AnotherProtocolOrOtherMessagesAreRefusedWithBothVersions) {
  RunningServer server;
  Hello other;
  other.version = "9.8.7";
  other.protocol = kNetworkProtocol + 1;
  const std::string number = std::to_string(kNetworkProtocol), next = std::to_string(kNetworkProtocol + 1);
  const std::string protocol = "another version: this is 1.2.3 with protocol " + number +
                               ", the hand's is 9.8.7 with protocol " + next + "; take the same on both sides";
  EXPECT_EQ(refusal(server.port(), other), protocol);
  other.protocol = kNetworkProtocol;
  ++other.schema;
  const std::string schema = "another version: this is 1.2.3 with protocol " + number +
                             ", the hand's is 9.8.7 with protocol " + number +
                             " and other messages; take the same on both sides";
  EXPECT_EQ(refusal(server.port(), other), schema);
  --other.schema;
  EXPECT_EQ(refusal(server.port(), other), "not refused");  // the same messages: that will do
  const auto& said = server.end();
  ASSERT_GE(said.size(), 3u);
  EXPECT_EQ(said[0], "127.0.0.1 refused: " + protocol);
  EXPECT_EQ(said[1], "127.0.0.1 refused: " + schema);
  EXPECT_EQ(said[2], "127.0.0.1 connected");
}

TEST(Versions, AMessageThatIsNoneGetsNoAnswerAndHarmsNobody) {
  RunningServer server;
  ControlClientOptions options;
  options.port = server.port();
  ControlClient client(options);
  const std::vector<std::uint8_t> nonsense(100, 0xa5);
  for (int i = 0; i < 500 && client.trouble() != ClientTrouble::none; ++i) client.poll(10);
  EXPECT_TRUE(client.send(nonsense));
  EXPECT_FALSE(client.poll(100));
  EXPECT_EQ(refusal(server.port(), Hello{}), "not refused");
}

}  // namespace
}  // namespace kt
