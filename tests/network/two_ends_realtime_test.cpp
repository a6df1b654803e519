// Body and hand in one process, over sockets. Against the wall clock: nothing here judges times.
#include <gtest/gtest.h>

#include <thread>

#include "haptics/session/session.hpp"
#include "network/body_server.hpp"
#include "network/hand_link.hpp"
#include "network/udp_relay.hpp"
#include "tests/support/allocations.hpp"
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

Scene one_second() {
  Scene scene = over_network(small_scene());
  scene.duration = 1;
  return scene;
}

TEST(TwoEnds, ARunOverTheNetworkIsFeltAndItsReplayHasTheSameBits) {
  const Scene scene = one_second();
  ServedBody body(scene);
  Session session(scene);
  EXPECT_THROW(session.run(), InputError);  // there is no body here
  SessionOptions options;
  options.count_allocations = thread_allocations() >= 0 ? std::function<long long()>(thread_allocations) : nullptr;
  const TouchedRun run = touch(session, body.port(), options);
  ASSERT_EQ(run.result.tools[0].frames.size(), 1000u);
  double most = 0;
  for (const LocalFrame& f : run.result.tools[0].frames) {
    ASSERT_TRUE(f.force.allFinite());
    most = std::max(most, f.f_n);
  }
  EXPECT_GT(most, 0.01);
  EXPECT_LE(run.result.allocations, 0);  // -1: not counted, under a sanitizer
  EXPECT_EQ(run.report.models_wrong, 0) << run.report.last_trouble;
  EXPECT_EQ(run.report.port.opened.refused(), 0);
  EXPECT_GT(run.result.refreshes.size(), 2u);
  EXPECT_EQ(run.result.refreshes[0].adopted_tick, 0);
  SessionOptions replay = replay_of(run.result);
  EXPECT_EQ(session.run(replay).hash, run.result.hash);
  const auto& ended = body.end();
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_EQ(ended[0].wrong_messages, 0);
  EXPECT_EQ(ended[0].body.misfits, 0);
  EXPECT_GT(ended[0].ticks, 900);
}

TEST(TwoEnds, ThroughABadNetworkTheReplayHasTheSameBitsToo) {
  const Scene scene = one_second();
  ServedBody body(scene);
  UdpRelay relay({.host_port = body.port(), .delay_ms = 10, .jitter_ms = 5, .loss = 0.3, .duplicate = 0.1, .seed = 36});
  Session session(scene);
  const TouchedRun run = touch(session, body.port(), {}, relay.port());
  ASSERT_EQ(run.result.tools[0].frames.size(), 1000u);
  EXPECT_EQ(run.report.models_wrong, 0) << run.report.last_trouble;
  SessionOptions replay = replay_of(run.result);
  EXPECT_EQ(session.run(replay).hash, run.result.hash);
  const auto& ended = body.end();
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_EQ(ended[0].wrong_messages, 0);
}

/// A ball at rest in a body whose cells are refined under it. They are made on both sides; what they had yielded by
/// stays at the hand's. Whether a model was adopted: on a machine that is busy enough none is, in two seconds.
void press_on_refined_cells(const std::string& body_kind, bool& adopts) {
  Scene scene = small_scene();
  scene.duration = 2;
  scene.object.body = body_kind;
  if (body_kind == "lattice") scene.object.lattice = SceneLattice{.edge = 0.008, .nodes = {}};
  scene.object.model.type = "fem";
  scene.tool.path.press_drag->speed = 0;
  scene.local.refine = "follow";
  scene.local.refine_nodes = 600;
  const double here = Session(scene).run().tools[0].frames.back().f_n;
  ASSERT_GT(here, 0.01);
  scene = over_network(scene);
  ServedBody body(scene);
  UdpRelay relay({.host_port = body.port(), .delay_ms = 10, .jitter_ms = 5, .loss = 0.2, .duplicate = 0.1, .seed = 36});
  Session session(scene);
  const TouchedRun run = touch(session, body.port(), {}, relay.port());
  ASSERT_EQ(run.result.tools[0].frames.size(), 2000u);
  EXPECT_EQ(run.report.models_wrong, 0) << run.report.last_trouble;
  adopts = run.report.models_adopted > 0;  // how many, a busy machine decides
  if (!adopts) return;
  const auto is_refined = [](const LocalFrame& f) { return f.f_n > 0 && !(f.flags & kUnrefined); };
  EXPECT_GT(std::ranges::count_if(run.result.tools[0].frames, is_refined), 0);
  const LocalFrame& last = run.result.tools[0].frames.back();
  int of_last = 0;  // tick that the model in use was linearized at; the press ends at 100
  for (const RefreshEvent& r : run.result.refreshes)
    if (r.adopted_tick >= 0) of_last = std::max(of_last, r.linearized_tick);
  if (is_refined(last) && of_last > 250) {  // a busy machine may be late with the cells
    // Another delay refines other cells: 1.01 to 1.06 of it at rest. The cells as they are give 2.5 times.
    // Of a lattice late models still find two sizes of cells at rest, 1.25 apart: docs/limitations.md.
    EXPECT_NEAR(last.f_n, here, (body_kind == "lattice" ? 0.35 : 0.15) * here);
  }
  SessionOptions replay = replay_of(run.result);
  EXPECT_EQ(session.run(replay).hash, run.result.hash);
  const auto& ended = body.end();
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_EQ(ended[0].wrong_messages, 0);
}

TEST(TwoEnds, RefinedCellsAreFeltAndTheReplayHasTheSameBits) {
  bool adopts = false;
  for (int tries = 0; tries < 3 && !adopts; ++tries) press_on_refined_cells("mesh", adopts);
  EXPECT_TRUE(adopts);
}
TEST(TwoEnds, ALatticeIsFeltAndTheReplayHasTheSameBits) {
  bool adopts = false;
  for (int tries = 0; tries < 3 && !adopts; ++tries) press_on_refined_cells("lattice", adopts);
  EXPECT_TRUE(adopts);
}

/// The hand tells of a loss when it has got some models, and that takes its way back: parity is there from the start.
TEST(TwoEnds, ModelsArriveBeforeTheirLossIsKnown) {
  Scene scene = one_second();
  scene.duration = 3;  // 12 models; a busy machine makes fewer
  ServedBody body(scene);
  UdpRelay relay({.host_port = body.port(), .delay_ms = 200, .loss = 0.2, .seed = 7});
  Session session(scene);
  const TouchedRun run = touch(session, body.port(), {}, relay.port());
  const auto& ended = body.end();
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_GE(ended[0].body.models, 5);
  EXPECT_LE(run.report.port.joined.given_up, 1);
}

/// TCP comes through and UDP does not, as with a firewall: nothing is felt, and the port is named.
TEST(TwoEnds, WithoutDatagramsThereIsNoRun) {
  const Scene scene = one_second();
  ServedBody body(scene);
  const UdpSocket swallows = UdpSocket::bound("127.0.0.1", 0);
  Session session(scene);
  try {
    touch(session, body.port(), {}, swallows.port());
    FAIL() << "a run over a line that lets nothing through";
  } catch (const RunError& e) {
    const std::string said = e.what();
    EXPECT_TRUE(said.starts_with(text("127.0.0.1:", swallows.port(), ": no datagram comes back over UDP"))) << said;
  }
  const auto& ended = body.end();
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_TRUE(ended[0].begun);
  EXPECT_EQ(ended[0].port.opened.opened, 0);
}

/// Makes the line dark between two times.
class Darkener final : public SessionWatcher {
 public:
  Darkener(UdpRelay& relay, double from, double to) : relay_(relay), from_(from), to_(to) {}
  void ticked(std::span<const LocalFrame> frames, double, long long) override {
    relay_.set_dark(frames[0].t >= from_ && frames[0].t < to_);
  }

 private:
  UdpRelay& relay_;
  double from_, to_;
};

TEST(TwoEnds, DatagramsThatStopTakeTheForceAndMayComeBack) {
  Scene scene = one_second();
  for (const double back : {3.5, 100.0}) {
    scene.duration = 6;
    scene.tool.path.press_drag->speed = 0.002;
    scene.link.stale_ms = 1000;  // beside other programs a refresh took 260 ms, and models were always older than 400
    ServedBody body(scene);
    UdpRelay relay({.host_port = body.port()});
    Session session(scene);
    Darkener darkener(relay, 1, back);
    SessionOptions options;
    options.watcher = &darkener;
    const TouchedRun run = touch(session, body.port(), options, relay.port());
    double before = 0, dark = 0, after = 0;
    for (const LocalFrame& f : run.result.tools[0].frames) {
      double& most = f.t < 1 ? before : f.t > 2.5 && f.t < 3.4 ? dark : f.t > 4.5 ? after : before;
      most = std::max(most, f.force.norm());
    }
    EXPECT_GT(before, 0.01);
    EXPECT_EQ(dark, 0) << "the force of a model that nobody renews";
    EXPECT_EQ(run.report.reconnections, 0);
    EXPECT_GT(run.report.longest_silence_s, 1.4);
    EXPECT_EQ(after > 0.01, back < 6);
    EXPECT_EQ(run.report.without_body.empty(), back < 6) << run.report.without_body;
  }
}

TEST(TwoEnds, AHandThatTakesLongToBuildIsWaitedFor) {
  Scene scene = one_second();
  scene.duration = 0.05;
  ServedBody body(scene);
  Session session(scene);
  const auto connection =
      std::make_shared<HandConnection>(HandConnectionOptions{.port = body.port(), .version = "test", .wait = 20});
  const Welcome welcome = connection->greet({});
  std::this_thread::sleep_for(std::chrono::milliseconds(3500));  // more than the silence that ends a session
  SessionOptions options;
  options.link = make_hand_link(connection, welcome, std::make_shared<HandLinkReport>(), {});
  EXPECT_EQ(session.run(options).tools[0].frames.size(), 50u);
}

/// Raises the friction in the middle.
class Setter final : public SessionWatcher {
 public:
  void begun(Touch& touch) override {
    touch_ = &touch;
    touch.set("contact.mu_kinetic", 0.3);  // before the first tick, as a page does after a reset
  }
  void ticked(std::span<const LocalFrame> frames, double, long long) override {
    if (!is_done_ && frames[0].t > kChanged) touch_->set("contact.mu", 0.9);
    is_done_ = is_done_ || frames[0].t > kChanged;
  }

 private:
  static constexpr double kChanged = 0.2;  // [s]
  Touch* touch_ = nullptr;
  bool is_done_ = false;
};

TEST(TwoEnds, ASettingReachesTheBodyAndComesBackWithItsModels) {
  Scene scene = one_second();
  scene.duration = 1.5;  // a busy machine takes its time
  ServedBody body(scene);
  Session session(scene);
  Setter setter;
  SessionOptions options;
  options.watcher = &setter;
  const TouchedRun run = touch(session, body.port(), options);
  ASSERT_EQ(run.result.setting_changes.size(), 2u);
  EXPECT_EQ(run.result.setting_changes[0].key, "contact.mu_kinetic");
  EXPECT_EQ(run.result.setting_changes[1].key, "contact.mu");
  double most = 0;  // of the cone at the end, where 0.9 rules
  for (const LocalFrame& f : run.result.tools[0].frames)
    if (f.t > 1.2) most = std::max(most, f.cone_ratio);
  EXPECT_GT(most, 0.55);
  SessionOptions replay = replay_of(run.result);
  EXPECT_EQ(session.run(replay).hash, run.result.hash);
}

}  // namespace
}  // namespace kt
