// Body and hand in one process, over sockets. Against the wall clock: nothing here judges times.
#include <gtest/gtest.h>

#include <thread>

#include "haptics/session/session.hpp"
#include "network/body_server.hpp"
#include "network/hand_link.hpp"
#include "tests/support/haptics_scene.hpp"

namespace kt {
namespace {

Scene over_network(Scene scene) {
  scene.link.type = "network";
  return scene;
}

/// A body that is served in a thread of its own.
class ServedBody {
 public:
  explicit ServedBody(const Scene& scene, int port = 0, bool once = false)
      : built_(scene),
        server_(built_, "{}", {}, {.port = port, .version = "test", .once = once, .stop = &stop_},
                [](const std::string&) {}),
        thread_([this] { server_.run([this](const ServedSession& s) { ended_.push_back(s); }); }) {}
  ~ServedBody() { end(); }
  const std::vector<ServedSession>& end() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
    return ended_;
  }
  int port() const { return server_.port(); }

 private:
  std::atomic<bool> stop_{false};
  BuiltScene built_;
  BodyServer server_;
  std::vector<ServedSession> ended_;
  std::thread thread_;
};

struct TouchedRun {
  SessionResult result;
  HandLinkReport report;
};

TouchedRun touch(Session& session, int port, SessionOptions options = {}, int data_port = 0) {
  const auto connection = std::make_shared<HandConnection>(
      HandConnectionOptions{.port = port, .data_port = data_port, .version = "test", .wait = 20});
  const Welcome welcome = connection->greet({});
  const auto report = std::make_shared<HandLinkReport>();
  options.link = make_hand_link(connection, welcome, report, {});
  TouchedRun out;
  out.result = session.run(options);
  out.report = *report;
  return out;
}

TEST(TwoEnds, ARunOverTheNetworkIsFeltAndItsReplayHasTheSameBits) {
  const Scene scene = over_network(small_scene());
  ServedBody body(scene);
  Session session(scene);
  EXPECT_THROW(session.run(), InputError);  // there is no body here
  const TouchedRun run = touch(session, body.port());
  ASSERT_EQ(run.result.tools[0].frames.size(), 300u);
  double most = 0;
  for (const LocalFrame& f : run.result.tools[0].frames) {
    ASSERT_TRUE(f.force.allFinite());
    most = std::max(most, f.f_n);
  }
  EXPECT_GT(most, 0.01);
  EXPECT_GT(run.report.models_adopted, 2);
  EXPECT_EQ(run.report.models_wrong, 0) << run.report.last_trouble;
  EXPECT_GT(run.result.refreshes.size(), 2u);
  EXPECT_EQ(run.result.refreshes[0].adopted_tick, 0);
  SessionOptions replay = replay_of(run.result);
  EXPECT_EQ(session.run(replay).hash, run.result.hash);
  const auto& ended = body.end();
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_EQ(ended[0].wrong_messages, 0);
  EXPECT_EQ(ended[0].body.misfits, 0);
  EXPECT_GT(ended[0].ticks, 290);
}

}  // namespace
}  // namespace kt
