// What a body's computer says to hands that come, come twice, come beside one another, or mean ill.
#include "network/body_server.hpp"

#include <gtest/gtest.h>

#include <mutex>
#include <thread>

#include "network/control/control_client.hpp"
#include "network/message/messages.hpp"
#include "network/refusal_log.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

Scene served_scene() {
  Scene scene = small_scene();
  scene.link.type = "network";
  return scene;
}

/// A body that is served in a thread of its own, and its log.
class Served {
 public:
  Served()
      : built_(served_scene()),
        server_(built_, "{}", {{"object_mesh.off", Bytes(1 << 20)}}, {.version = "test", .stop = &stop_},
                [this](const std::string& line) {
                  const std::scoped_lock lock(guard_);
                  log_.push_back(line);
                }),
        thread_([this] { server_.run({}); }) {}
  ~Served() {
    stop_ = true;
    thread_.join();
  }
  int port() const { return server_.port(); }
  std::vector<std::string> log() const {
    const std::scoped_lock lock(guard_);
    return log_;
  }

 private:
  std::atomic<bool> stop_{false};
  mutable std::mutex guard_;
  std::vector<std::string> log_;
  BuiltScene built_;
  BodyServer server_;
  std::thread thread_;
};

/// A hand that says what the test wants.
class Hand {
 public:
  explicit Hand(int port) : client_({.port = port}) {
    for (const auto end = Clock::now() + 20s; client_.trouble() != ClientTrouble::none && Clock::now() < end;)
      client_.poll(10);
    EXPECT_EQ(client_.trouble(), ClientTrouble::none);
  }
  void say(const ControlMessage& message) { EXPECT_TRUE(client_.send(encode(message))); }

  /// The next message that is no ping and no record of a refresh; none came in the time.
  std::optional<ControlMessage> hear(std::chrono::milliseconds most = 20s) {
    for (const auto end = Clock::now() + most; Clock::now() < end;) {
      const auto bytes = client_.poll(20);
      auto message = bytes ? decode_control(*bytes) : std::nullopt;
      const bool is_aside =
          message && (std::holds_alternative<Ping>(*message) || std::holds_alternative<RecordMessage>(*message));
      if (message && !is_aside) return message;
    }
    return {};
  }
  template <class T>
  T hear_a() {
    const auto message = hear();
    if (message && std::holds_alternative<T>(*message)) return std::get<T>(*message);
    ADD_FAILURE() << "another message came, or none";
    return {};
  }

 private:
  ControlClient client_;
};

Begin begin_of(std::uint64_t session) { return {session, {Pose{Vec3(0, 0, 0.1), Quaternion::Identity()}}, {0.25}, {}}; }

TEST(BodyServer, AHandThatBuildsItsHalfKeepsTheBody) {
  const Served body;
  Hand first(body.port()), second(body.port());
  first.say(Hello{});
  const Welcome welcome = first.hear_a<Welcome>();
  second.say(Hello{});
  EXPECT_EQ(second.hear_a<Bye>().reason, kTaken);
  first.say(begin_of(welcome.session));
  EXPECT_TRUE(decode_model(first.hear_a<FirstModel>().model));
  second.say(Hello{});
  EXPECT_EQ(second.hear_a<Bye>().reason, kTaken);
  first.say(End{});
  EXPECT_EQ(first.hear_a<Bye>().reason, kEnded);
  second.say(Hello{});
  EXPECT_NE(second.hear_a<Welcome>().session, welcome.session);
}

TEST(BodyServer, AHandThatDiesWhileItBuildsKeepsNothing) {
  const Served body;
  {
    Hand first(body.port());
    first.say(Hello{});
    first.hear_a<Welcome>();
  }
  Hand second(body.port());
  for (const auto end = Clock::now() + 20s; Clock::now() < end;) {
    second.say(Hello{});
    const auto answer = second.hear();
    ASSERT_TRUE(answer);
    if (std::holds_alternative<Welcome>(*answer)) return;
    std::this_thread::sleep_for(50ms);
  }
  ADD_FAILURE() << "the body stayed with a hand that was gone";
}

TEST(BodyServer, AHandThatLostItsConnectionComesBackAtOnce) {
  const Served body;
  Hand first(body.port());
  first.say(Hello{});
  const Welcome welcome = first.hear_a<Welcome>();
  first.say(begin_of(welcome.session));
  first.hear_a<FirstModel>();
  Hand same(body.port());
  same.say(Hello{.version = "", .session = welcome.session});
  EXPECT_NE(same.hear_a<Welcome>().session, welcome.session);
}

TEST(BodyServer, WhoAsksAgainAndAgainGetsTheMeshOnce) {
  const Served body;
  Hand hand(body.port());
  int welcomes = 0;
  for (int i = 0; i < 40; ++i) {
    hand.say(Hello{});
    if (i % 2) hand.say(End{});
    while (const auto answer = hand.hear(i < 39 ? 1ms : 1s)) welcomes += std::holds_alternative<Welcome>(*answer);
  }
  EXPECT_EQ(welcomes, 1);
}

TEST(BodyServer, ManyWhoReadNothingAreSentItAFewTimes) {
  const Served body;
  std::vector<std::unique_ptr<Hand>> hands;
  for (int i = 0; i < 12; ++i) {
    hands.push_back(std::make_unique<Hand>(body.port()));
    hands.back()->say(Hello{});
    hands.back()->say(End{});
  }
  int welcomes = 0;
  for (const auto& hand : hands)
    for (std::optional<ControlMessage> answer = hand->hear(3s); answer; answer = hand->hear(200ms))
      welcomes += std::holds_alternative<Welcome>(*answer);
  EXPECT_GE(welcomes, 1);
  EXPECT_LE(welcomes, 4);
}

TEST(BodyServer, ASessionThatIsOverIsSaid) {
  const Served body;
  Hand hand(body.port());
  hand.say(begin_of(7));
  EXPECT_EQ(hand.hear_a<Bye>().reason, kOver);
}

TEST(BodyServer, WhatAHandSaysOfItselfIsOneShortLineAndNoFlood) {
  const Served body;
  Hand hand(body.port());
  for (int i = 0; i < 100; ++i) {
    hand.say(Hello{.protocol = 7,
                   .version = text(i, "9\n127.0.0.1 connected with key AAAA\x1b[2J", std::string(5000, 'x'))});
    EXPECT_FALSE(hand.hear_a<Bye>().reason.empty());
  }
  const auto log = body.log();
  EXPECT_GE(log.size(), 1u);
  EXPECT_LE(log.size(), 40u);  // a machine that is busy takes its time: one more each 5 s
  for (const std::string& line : log) {
    EXPECT_EQ(line.find_first_of("\n\x1b"), std::string::npos) << line;
    EXPECT_LT(line.size(), 600u) << line;
    EXPECT_NE(line.find(" refused: another version"), std::string::npos) << line;
  }
}

TEST(RefusalLog, TellsOfThoseItDidNotTell) {
  std::vector<std::string> lines;
  RefusalLog log([&](const std::string& line) { lines.push_back(line); });
  RefusalLog::Time now{std::chrono::hours(1)};
  for (int i = 0; i < 30; ++i) log.add("a", "why", now += 1ms);
  EXPECT_EQ(lines.size(), 8u);
  log.add("b", "wh\ny", now += 60s);
  ASSERT_EQ(lines.size(), 9u);
  EXPECT_EQ(lines.back(), "b refused: wh\\ny; and 22 more refusals before");
}

}  // namespace
}  // namespace kt
