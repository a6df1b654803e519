#include "network/hand_link.hpp"

#include <map>
#include <mutex>
#include <thread>

#include "core/base/finding.hpp"
#include "core/base/numbers.hpp"
#include "core/base/ticks.hpp"
#include "haptics/options/band_powers.hpp"
#include "network/channel/parity.hpp"
#include "network/model_worker.hpp"

namespace kt {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr auto kServerSilence = 1500ms;     // of the server: it is gone
constexpr auto kOwnPause = 500ms;           // between two looks at what has come: this computer stood still
constexpr auto kNoDatagram = 4s;            // at the start: none comes through
constexpr std::size_t kDatagramRoom = 900;  // bytes of reports in one datagram, beside what all of them share
constexpr int kCopies = 4;                  // datagrams that each report travels in
constexpr int kMostBehind = 64;             // ticks whose reports go at once after a pause
constexpr double kEvery = 0.004;            // [s] between them, when there is little to tell

class HandLink final : public BodyLink, private RemoteBody {
 public:
  HandLink(std::shared_ptr<HandConnection> connection, const Welcome& welcome, std::shared_ptr<HandLinkReport> report,
           std::function<void(const std::string&)> say, std::function<void()> gave_up, BodySide& body, HapticSide& side,
           const SurfaceFriction& friction, ModelObserver* observer)
      : connection_(std::move(connection)),
        report_(std::move(report)),
        say_(std::move(say)),
        gave_up_(std::move(gave_up)),
        options_(body.options()),
        observer_(observer),
        tools_(static_cast<int>(side.num_tools())),
        nodes_(body.body().model().mesh().num_nodes()),
        body_hash_(welcome.body_hash),
        ticks_(options_, observer),
        history_(side.poses(), side.next_tick()),
        worker_(body.body(), options_, friction, observer, ticks_, history_),
        motion_every_(std::max(1, ticks_per_refresh(options_) / 4)) {
    const ModelMessage first = reach_body(welcome, side.next_tick(), side.poses());
    side.adopt(worker_.first(first));
    if (observer_) observer_->adopted(side.model());
    adopted_frame_ = first.model.frame;
    for (int i = 0; i < 2; ++i) rooms_.push_back(std::make_unique<LocalMotion>(make_local_motion(nodes_)));
    began_ = heard_ = datagram_ = looked_ = Clock::now();
    worker_.start();
    thread_ = std::thread([this] { run(); });
  }
  ~HandLink() override { stop(); }

  void before_tick(HapticSide& side) noexcept override { ticks_.before_tick(side); }
  void after_tick(HapticSide& side, const LocalReport& report) noexcept override { ticks_.after_tick(side, report); }

  void stop() override {
    if (!thread_.joinable()) return;
    stop_ = true;
    thread_.join();
    worker_.stop();
    fill_report();
  }
  std::exception_ptr error() const noexcept override { return nullptr; }  // the force goes to zero, ticks go on
  bool has_failed() const noexcept override { return has_failed_.load(std::memory_order_acquire); }
  int lost_reports() const noexcept override { return ticks_.lost_reports(); }
  RemoteBody* remote() noexcept override { return this; }

 private:
  TouchStatus status() const override { return worker_.status(); }
  void copy_positions(VectorX& x) const override { worker_.copy_positions(x); }

  void set(const SettingChange& change) override {
    const std::scoped_lock lock(asking_);
    requests_.push_back({++asked_, change.key, change.value, change.word});
  }

  Begin begin_message(const Welcome& welcome, std::span<const Pose> tools) const {
    Begin out{welcome.session,
              {tools.begin(), tools.end()},
              {},
              options_.motion ? std::optional(*options_.motion) : std::nullopt};
    for (const TouchTool& tool : options_.tools) out.max_speed.push_back(tool.max_speed);
    return out;
  }

  /// The first local model, of a server that may go and come back meanwhile. Throws RunError: it did not come back, or
  /// datagrams do not come through.
  ModelMessage reach_body(Welcome welcome, int tick, std::span<const Pose> tools) {
    std::optional<Clock::time_point> end;
    for (;;) {
      begin_session(welcome, tick);
      if (auto first = connection_->begin(begin_message(welcome, tools))) {
        session_models_ = 1;
        require_datagrams();
        return std::move(*first);
      }
      const auto now = Clock::now();
      if (!end) end = now + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(wait_s()));
      if (now >= *end)
        throw RunError(
            text("the body's computer went away before its first local model; waited for ", wait_s(), " s (--wait)"));
      if (say_) say_("the body's computer went away before its first local model");
      connection_->ask_again();
      welcome = connection_->greet(say_);
      if (welcome.body_hash != body_hash_) throw RunError("the body's computer has another body now");
    }
  }

  /// Nothing is felt over a line that lets no datagram through, however well the control channel does.
  void require_datagrams() {
    for (const auto end = Clock::now() + kNoDatagram; Clock::now() < end;) {
      port_->send(DatagramKind::alive, {}, -1);
      port_->poll(20ms);
      if (port_->heard() > Clock::time_point{}) return;
      if (connection_->options().stop && connection_->options().stop->load())
        throw RunError("stopped before the first datagram came");
    }
    connection_->send(End{});  // the body is free for the next one; its word for it is waited for, or this is lost
    for (const auto end = Clock::now() + 1s; Clock::now() < end;)
      if (const auto message = connection_->poll(20); message && std::holds_alternative<Bye>(*message)) break;
    throw RunError(no_datagram() + "; let that UDP port through (firewall, router), or name a relay with --data");
  }

  std::string no_datagram() const {
    return text(figures_.data_place, ": no datagram comes back over UDP, though ", connection_->place(),
                " answers over TCP");
  }

  static double seconds_since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }
  double wait_s() const { return connection_->options().wait; }

  void begin_session(const Welcome& welcome, int tick) {
    leave_session();
    port_ = connection_->open_port(welcome);
    figures_.data_place = connection_->data_place(welcome);
    session_ = welcome.session;
    worker_.forget();
    is_over_ = false;
    outbox_.emplace(static_cast<std::size_t>(kCopies) * 64, tick_length(options_));
    tick0_ = tick;
    sent_end_ = motion_due_ = 0;
    adopted_frame_ = adopted_tick_ = -1;
  }

  /// What the session that is over came to.
  void leave_session() {
    if (!port_) return;
    figures_.port += port_->counts();
    figures_.models_sent += session_models_;
    session_models_ = 0;
    port_.reset();
  }

  /// What goes wrong here ends the force, not the program: the ticks' records are kept.
  void run() {
    try {
      while (!stop_) go_on();
      say_goodbye();
    } catch (const std::exception& e) {
      is_lost_ = true;
      give_up(text("the link to the body's computer ended: ", e.what()));
    }
  }

  void go_on() {
    take_used();
    take_reports();
    send_reports();
    ask_motion();
    listen();
    control();
  }

  /// Models that were in use come back.
  void take_used() {
    auto parcel = ticks_.take_used();
    if (!parcel) return;
    adopted_at_[parcel->linearized_tick] = parcel->adopted_tick;
    adopted_frame_ = parcel->frame;
    adopted_tick_ = parcel->adopted_tick - tick0_;
    const int late = parcel->adopted_tick - parcel->linearized_tick;
    worker_.set_late(late);
    const double tick_ms = 1e3 * tick_length(options_);
    figures_.age_ms.push_back(tick_ms * late);
    if (const auto way = worker_.take_way(parcel->frame)) {
      figures_.body_ms.push_back(way->body_ms);
      figures_.hand_ms.push_back(tick_ms * (parcel->adopted_tick - way->came_at));
    }
    worker_.look_back_on(std::move(parcel->model));
  }

  /// What the ticks have told; a motion goes when the report of the tick before it is there.
  void take_reports() {
    if (!motion_) motion_ = ticks_.take_motion();
    LocalReport& report = report_in_;
    while (ticks_.reports().pop(report)) {
      if (report.tick == history_.end())
        history_.add(report);
      else
        history_.begin_anew(report);
      if (is_lost_ && !is_beginning_) continue;
      if (report.tick < tick0_) continue;
      is_at_edge_ = report.left_patch;
      report.tick -= tick0_;
      outbox_->add(report);
    }
    if (motion_ && history_.end() >= motion_->tick) send_motion();
  }

  ReportMessage with_state(ReportBatch batch) {
    ReportMessage out{std::move(batch), port_->loss(), port_->feedback()};
    out.batch.adopted_frame = adopted_frame_;
    out.batch.adopted_tick = adopted_tick_;
    return out;
  }

  void send_motion() {
    std::unique_ptr<LocalMotion> motion = std::move(motion_);
    const int before = motion->tick - tick0_ - 1;
    if (!is_lost_ && outbox_->has(before)) {
      worker_.note(*motion);
      MotionMessage out;
      out.frame = motion->frame;
      // Those whose other datagrams are still to come: the body closes the interval with this message.
      out.reports = with_state(outbox_->batch_to(before, static_cast<std::size_t>(kCopies * ticks_a_datagram())));
      out.recovered = static_cast<int>(std::ranges::count_if(motion->row, [](int r) { return r >= 0; }));
      out.patch = motion->num_patch;
      motion->tick -= tick0_;
      std::swap(out.motion, *motion);
      // Parity for what is small costs little: a motion that is lost makes a model a quarter of an interval later.
      port_->send(DatagramKind::motion, encode(out, tools_), std::max(kLossUntilKnown, worker_.loss().value_or(0)));
      std::swap(out.motion, *motion);
    }
    rooms_.push_back(std::move(motion));
  }

  /// Ticks from one datagram of reports to the next: as many as it has room for kCopies of.
  int ticks_a_datagram() const {
    const std::size_t size = 8 + static_cast<std::size_t>(48 * tools_ + 60 * outbox_->last().count);
    const int most = std::max(1, ticks_in(kEvery, options_.local.rate_hz));
    return std::clamp(static_cast<int>(kDatagramRoom / size) / kCopies, 1, most);
  }

  /// Each report in kCopies datagrams.
  void send_reports() {
    if (is_lost_ || outbox_->empty()) return;
    const int end = outbox_->last().tick + 1, every = ticks_a_datagram();
    // After a pause of this thread what waits goes in as many datagrams as without; of very long ones the sums tell.
    sent_end_ = std::max(sent_end_, end - kMostBehind);
    for (; end - sent_end_ >= every; sent_end_ += every) {
      const int last = sent_end_ + every - 1;
      if (!outbox_->has(last)) continue;
      ReportBatch batch = outbox_->batch_to(last, static_cast<std::size_t>(kCopies * every));
      port_->send(DatagramKind::reports, encode(with_state(std::move(batch)), tools_), -1);
    }
  }

  void ask_motion() {
    const int now = history_.end();
    if (rooms_.empty() || (now < motion_due_ && !(is_at_edge_ && now >= motion_due_ - motion_every_ / 2))) return;
    if (!ticks_.ask_motion(rooms_.back())) return;
    rooms_.pop_back();
    motion_due_ = now + motion_every_;
  }

  void listen() {
    if (is_lost_ && !is_beginning_) {
      std::this_thread::sleep_for(1ms);
      return;
    }
    const auto message = port_->poll(500us);
    if (port_->heard() > heard_) heard_ = port_->heard();
    if (port_->heard() > datagram_) hear_datagrams();
    if (message && message->kind == static_cast<std::uint8_t>(DatagramKind::model) && !is_lost_) {
      session_models_ = std::max(session_models_, 2 + static_cast<int>(message->number));  // the first came by control
      worker_.put(message->bytes, tick0_);
    }
  }

  void control() {
    const auto now = Clock::now();
    if (now < next_control_) return;
    take_own_pause(now);
    next_control_ = now + 5ms;
    ask();
    if (now >= next_ping_) {  // while time stands still there is nothing else to say
      connection_->send(Ping{});
      if (!is_lost_) port_->send(DatagramKind::alive, {}, -1);
      next_ping_ = now + 250ms;
    }
    while (const auto message = connection_->poll(0)) receive(*message);
    if (!is_lost_ && (now - heard_ > kServerSilence)) lose("nothing was heard of it");
    if (is_lost_)
      look_for_server(now);
    else if (now - datagram_ > kServerSilence)
      miss_datagrams();
  }

  /// While this thread does not run, nothing is heard, whatever the other side says: that is no silence of it.
  void take_own_pause(Clock::time_point now) {
    const auto pause = now - std::exchange(looked_, now);
    if (pause < kOwnPause) return;
    heard_ = std::max(heard_, std::min(now, heard_ + pause));
    datagram_ = std::max(datagram_, std::min(now, datagram_ + pause));
    const double seconds = std::chrono::duration<double>(pause).count();
    figures_.longest_own_pause_s = std::max(figures_.longest_own_pause_s, seconds);
    paused_at_ = now;
    if (say_) say_(text("this computer stood still for ", short_number(seconds), " s"));
  }

  void ask() {
    const std::scoped_lock lock(asking_);
    for (const SetRequest& request : requests_) connection_->send(request);
    requests_.clear();
  }

  void receive(const ControlMessage& message) {
    heard_ = Clock::now();
    if (const auto* m = std::get_if<RecordMessage>(&message)) {
      RefreshRecord record = m->record;
      record.event.linearized_tick += tick0_;
      record.event.started_tick += tick0_;
      const auto adopted = adopted_at_.find(record.event.linearized_tick);
      if (adopted != adopted_at_.end()) record.event.adopted_tick = adopted->second;
      if (record.event.linearized_tick == 0) record.event.adopted_tick = 0;
      if (observer_) observer_->refreshed(record);
    } else if (const auto* reply = std::get_if<SetReply>(&message)) {
      if (!reply->trouble.empty() && say_) say_("the body's computer: " + reply->trouble);
    } else if (const auto* bye = std::get_if<Bye>(&message)) {
      is_over_ = true;
      connection_->ask_again();
      is_beginning_ = false;
      next_try_ = heard_ + 1s;
      if (!stop_ && !is_lost_)
        lose(heard_ - paused_at_ < kOwnPause ? "it ended the session while this one stood still" : bye->reason);
    } else if (const auto* first = std::get_if<FirstModel>(&message); first && is_beginning_) {
      find_again(*first);
    } else if (const auto* welcome = std::get_if<Welcome>(&message);
               welcome && is_lost_ && welcome->session != session_) {
      greeted(*welcome);
    }
  }

  void lose(const std::string& why) {
    is_lost_ = true;
    is_beginning_ = false;
    lost_at_ = Clock::now();
    next_try_ = lost_at_;
    connection_->ask_again();  // over the same connection, too: what stood still may go on
    if (say_) say_(text("the body's computer is gone: ", why));
  }

  void look_for_server(Clock::time_point now) {
    if (seconds_since(lost_at_) > wait_s() && !has_failed_)
      give_up(text("the body's computer has been gone for ", wait_s(), " s"));
    if (now < next_try_ || has_failed_) return;
    next_try_ = now + 1s;
    if (std::exchange(is_beginning_, false)) connection_->ask_again();  // its first local model did not come
    connection_->ask(session_);
  }

  /// The server is there, its datagrams are not. The gate shuts when the local model is too old.
  void miss_datagrams() {
    const double silent = seconds_since(datagram_);
    figures_.longest_silence_s = std::max(figures_.longest_silence_s, silent);
    if (!std::exchange(is_deaf_, true) && say_) say_(no_datagram());
    if (silent > wait_s() && !has_failed_) give_up(text(no_datagram(), " for ", wait_s(), " s"));
  }

  void hear_datagrams() {
    datagram_ = port_->heard();
    if (std::exchange(is_deaf_, false) && say_) say_(text(figures_.data_place, ": datagrams come again"));
  }

  void give_up(const std::string& why) {
    worker_.fail(why);
    has_failed_.store(true, std::memory_order_release);
    figures_.without_body = why;
    if (gave_up_) gave_up_();
  }

  void greeted(const Welcome& welcome) {
    if (welcome.body_hash != body_hash_) return give_up("the body's computer has another body now");
    begin_session(welcome, history_.end());
    is_beginning_ = connection_->send(begin_message(welcome, history_.last()));
    next_try_ = Clock::now() + 20s;  // its first refresh takes its time
  }

  void find_again(const FirstModel& first) {
    is_beginning_ = is_lost_ = is_deaf_ = false;
    heard_ = datagram_ = Clock::now();
    session_models_ = 1;
    ++figures_.reconnections;
    const double gap = seconds_since(lost_at_);
    figures_.longest_gap_s = std::max(figures_.longest_gap_s, gap);
    worker_.put(first.model, tick0_);
    if (say_) say_(text("the body's computer is back after ", gap, " s"));
  }

  /// The server ends the session; what it has still to tell of refreshes comes first.
  void say_goodbye() {
    take_used();
    take_reports();
    if (is_lost_) return;
    send_reports();
    connection_->send(End{});
    const auto end = Clock::now() + 1s;  // a stop does not wait longer
    while (!is_over_ && Clock::now() < end)
      if (const auto message = connection_->poll(20)) receive(*message);
  }

  void fill_report() {
    HandLinkReport& f = figures_;
    if (port_) f.loss_down = port_->loss();
    leave_session();
    worker_.add_to(f);
    f.loss_up = worker_.loss();
    f.models_adopted = static_cast<int>(f.age_ms.size());
    f.seconds = seconds_since(began_);
    if (is_lost_) f.longest_gap_s = std::max(f.longest_gap_s, seconds_since(lost_at_));
    if (f.without_body.empty() && is_lost_) f.without_body = "the body's computer was gone when it ended";
    if (f.without_body.empty() && is_deaf_) f.without_body = no_datagram();
    *report_ = f;
  }

  std::shared_ptr<HandConnection> connection_;
  std::shared_ptr<HandLinkReport> report_;
  std::function<void(const std::string&)> say_;
  std::function<void()> gave_up_;
  TouchOptions options_;
  ModelObserver* observer_;
  int tools_, nodes_;
  std::uint64_t body_hash_;
  TickEnd ticks_;
  SharedHistory history_;
  ModelWorker worker_;
  std::atomic<bool> stop_{false}, has_failed_{false};

  // Of the link's own thread.
  std::unique_ptr<DatagramPort> port_;
  std::optional<ReportOutbox> outbox_;
  std::vector<std::unique_ptr<LocalMotion>> rooms_;
  std::unique_ptr<LocalMotion> motion_;  // to be sent
  std::map<int, int> adopted_at_;        // by the tick of the linearization
  int tick0_ = 0;                        // of the server's first tick
  int sent_end_ = 0, motion_due_ = 0, motion_every_;
  int adopted_frame_ = -1, adopted_tick_ = -1;  // as the server counts
  bool is_at_edge_ = false, is_lost_ = false, is_beginning_ = false, is_over_ = false;
  bool is_deaf_ = false;  // no datagram comes
  std::uint64_t session_ = 0;
  int session_models_ = 0;  // sent in this session, with the first one
  LocalReport report_in_;
  HandLinkReport figures_;
  Clock::time_point began_{}, heard_{}, datagram_{}, looked_{}, paused_at_{}, next_control_{}, next_ping_{}, lost_at_{},
      next_try_{};

  std::mutex asking_;  // of what follows
  std::uint32_t asked_ = 0;
  std::vector<SetRequest> requests_;
  std::thread thread_;
};

}  // namespace

LinkMaker make_hand_link(std::shared_ptr<HandConnection> connection, Welcome welcome,
                         std::shared_ptr<HandLinkReport> report, std::function<void(const std::string&)> say,
                         std::function<void()> gave_up) {
  return [=](BodySide& body, HapticSide& side, const SurfaceFriction& friction, ModelObserver* observer) {
    return std::make_unique<HandLink>(connection, welcome, report, say, gave_up, body, side, friction, observer);
  };
}

}  // namespace kt
