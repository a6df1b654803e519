#include "network/body_server.hpp"

#include <chrono>
#include <deque>
#include <thread>

#include "core/base/loopback.hpp"
#include "core/body/state.hpp"
#include "haptics/refresh/touch_parts.hpp"
#include "haptics/remote/model_unpacker.hpp"
#include "network/control/control_server.hpp"

namespace kt {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr auto kSilence = 3s;   // of a hand's datagrams: it is gone
constexpr long kFewSent = 500;  // datagrams

}  // namespace

std::uint64_t body_hash(const Body& body) {
  StateHash hash;
  const Mesh& mesh = body.model().mesh();
  hash.add(mesh.x);
  for (const Triangle& t : mesh.triangles)
    for (const int v : t) hash.add(v);
  for (const Tetrahedron& t : mesh.tetrahedra)
    for (const int v : t) hash.add(v);
  for (const int i : body.model().fixed_nodes()) hash.add(i);
  return hash.value();
}

namespace {

/// One hand's time with the body: its own key, thread and body at rest.
class ServedHand final : public ModelObserver {
 public:
  ServedHand(const BuiltScene& scene, const std::string& address, int port, std::string peer, std::string name)
      : scene_(scene),
        peer_(std::move(peer)),
        id_(new_session_id()),
        key_(new_seal_key()),
        port_(UdpSocket::bound(address, port), key_, Direction::to_hand) {
    ended_.peer = std::move(name);
    limits_.tools = static_cast<int>(scene.options().tools.size());
    limits_.triangles = static_cast<int>(scene.surface().triangles.size());
    limits_.nodes = scene.model().mesh().num_nodes();
    const Smoothing smoothing = contact_smoothing(scene.options().contact, scene.options().local);
    limits_.facets_per_triangle = 1 << (2 * smoothing.levels);
    limits_.h = 1 / scene.options().local.rate_hz;
    heard_ = Clock::now();
  }
  ~ServedHand() override { end(); }

  const std::string& peer() const { return peer_; }
  std::uint64_t id() const { return id_; }
  const SealKey& key() const { return key_; }
  bool has_begun() const { return body_ != nullptr; }
  const ServedSession& result() const { return ended_; }

  /// The first local model. Throws InputError, and what a refresh throws.
  FirstModel begin(const Begin& message) {
    TouchOptions options = scene_.options();
    options.link.type = "network";
    if (message.tools.size() != options.tools.size())
      throw InputError(text("the hand has ", message.tools.size(), " tools, the scene ", options.tools.size()));
    for (std::size_t k = 0; k < options.tools.size(); ++k) options.tools[k].max_speed = message.max_speed[k];
    options.motion = message.motion;
    body_ = std::make_unique<BodyEnd>(scene_.body(), options, this);
    const FirstModel first{encode(body_->begin(message.tools))};
    thread_ = std::thread([this] { refresh(); });
    heard_ = Clock::now();
    return first;
  }

  /// Waits for datagrams and sends what is ready, no longer than that.
  void pump(std::chrono::microseconds timeout) {
    send_model();
    const auto message = port_.poll(timeout);
    if (!message || !body_) return;
    heard_ = Clock::now();
    if (message->kind == static_cast<std::uint8_t>(DatagramKind::reports)) {
      auto reports = decode_reports(message->bytes, limits_);
      if (!reports) return count_wrong();
      ended_.ticks = std::max(ended_.ticks, reports->batch.last() + 1);
      body_->take(std::move(*reports));
    } else if (message->kind == static_cast<std::uint8_t>(DatagramKind::motion)) {
      auto motion = decode_motion(message->bytes, limits_);
      if (!motion) return count_wrong();
      body_->take(std::move(*motion));
    } else {
      count_wrong();
    }
  }

  void count_wrong() { ++ended_.wrong_messages; }
  bool is_silent() const { return Clock::now() - heard_ > kSilence; }
  void alive() { heard_ = Clock::now(); }

  /// Why the body's simulation ended; empty: it goes on.
  std::string error() const {
    const std::scoped_lock lock(guard_);
    return error_;
  }
  SetReply set(const SetRequest& m) {
    try {
      if (!body_) throw InputError(m.key + ": not before the first tick");
      body_->set({0, m.key, m.value, m.word});
      return {m.number, ""};
    } catch (const InputError& e) {
      return {m.number, e.what()};
    }
  }
  /// Refreshes that the hand is to be told of.
  std::vector<RefreshRecord> take_records() {
    const std::scoped_lock lock(guard_);
    return std::exchange(records_, {});
  }

  void end() {
    if (!thread_.joinable()) return;
    stop_ = true;
    thread_.join();
    body_->finish();
    ended_.body = body_->counts();
    ended_.port = port_.counts();
    ended_.loss_up = port_.loss();
    ended_.loss_down = body_->model_loss();
  }

  bool look(VectorX& x, LocalReport& tools, TouchStatus& status) const {
    if (!body_) return false;
    body_->copy_positions(x);
    tools = body_->last_report();
    status = body_->status();
    return true;
  }
  ServedSession& ended() { return ended_; }

 private:
  static std::uint64_t new_session_id() {
    const SealKey random = new_seal_key();
    std::uint64_t id = 0;
    for (std::size_t i = 0; i < 8; ++i) id = id << 8 | random[i];
    return id;
  }

  void refreshed(const RefreshRecord& record) override {
    const std::scoped_lock lock(guard_);
    records_.push_back(record);
  }

  void refresh() {
    try {
      while (!stop_) {
        body_->wait(5ms);
        auto model = body_->refresh_if_due();
        if (!model) continue;
        model->loss = loss_;
        Bytes bytes = encode(*model);
        const std::scoped_lock lock(guard_);
        ready_ = std::move(bytes);
      }
    } catch (const std::exception& e) {
      const std::scoped_lock lock(guard_);
      error_ = e.what();
    }
  }

  void send_model() {
    loss_ = port_.loss();
    std::optional<Bytes> bytes;
    {
      const std::scoped_lock lock(guard_);
      bytes = std::exchange(ready_, {});
    }
    if (!bytes) return;
    if (bytes->size() > kMostMessageBytes) {
      const std::scoped_lock lock(guard_);
      error_ = text("a local model has ", bytes->size(), " bytes, more than ", kMostMessageBytes,
                    " do not travel; set link.basis_bits 8, local.reducer krylov or a smaller tool");
      return;
    }
    // The hand can tell of a loss once it has got a few models; until then what is lost on the way here stands for it.
    const bool is_known = port_.counts().sent > kFewSent;
    const double loss = is_known ? body_->model_loss() : std::max(body_->model_loss(), port_.loss());
    port_.send(DatagramKind::model, std::move(*bytes), loss, false);
  }

  const BuiltScene& scene_;
  std::string peer_;
  std::uint64_t id_;
  SealKey key_;
  DatagramPort port_;
  WireLimits limits_;
  std::unique_ptr<BodyEnd> body_;
  ServedSession ended_;
  Clock::time_point heard_;
  std::atomic<double> loss_{0};  // of datagrams from the hand
  std::atomic<bool> stop_{false};
  mutable std::mutex guard_;  // of what follows
  std::vector<RefreshRecord> records_;
  std::optional<Bytes> ready_;
  std::string error_;
  std::thread thread_;
};

}  // namespace

struct BodyServer::Parts {
  Parts(const BuiltScene& touched, std::string scene_json, std::vector<Welcome::File> sent, const BodyServerOptions& o,
        Say tell)
      : scene(touched),
        json(std::move(scene_json)),
        files(std::move(sent)),
        options(o),
        say(std::move(tell)),
        control({.address = o.address, .port = o.port, .own = o.own, .authorized = o.authorized}),
        hash(body_hash(touched.body())) {}

  const BuiltScene& scene;
  std::string json;
  std::vector<Welcome::File> files;
  BodyServerOptions options;
  Say say;
  ControlServer control;
  std::uint64_t hash;
  mutable std::mutex looking;        // of `hand` itself, for look()
  std::unique_ptr<ServedHand> hand;  // who touches the body

  void answer(const ControlServer::Request& request);
  void welcome(const ControlServer::Request& request, const Hello& hello);
  void send_welcome() {
    control.send(hand->peer(), encode(Welcome{hand->id(), hand->key(), control.port(), json, files, hash}));
  }
  void begin(const Begin& message);
  void forward_records() {
    for (RefreshRecord& record : hand->take_records()) control.send(hand->peer(), encode(RecordMessage{record}));
  }
  void end(const std::string& reason, const std::function<void(const ServedSession&)>& ended);
  std::function<void(const ServedSession&)> told;
};

BodyServer::BodyServer(const BuiltScene& scene, std::string scene_json, std::vector<Welcome::File> files,
                       const BodyServerOptions& options, Say say) {
  require_sendable(scene.options());
  if (!is_loopback(options.address) && !options.own)
    throw InputError(
        text("--listen ", options.address,
             ": is not this computer's own address (127.0.0.1): others could touch the body; make keys with "
             "kilotouch key new DIR and give --keys DIR"));
  parts_ = std::make_unique<Parts>(scene, std::move(scene_json), std::move(files), options, std::move(say));
}

BodyServer::~BodyServer() = default;

int BodyServer::port() const { return parts_->control.port(); }

void BodyServer::Parts::welcome(const ControlServer::Request& request, const Hello& hello) {
  const auto refuse = [&](const std::string& why) {
    control.send(request.peer, encode(Bye{why}));
    say(text(request.address, " refused: ", why));
  };
  if (hello.protocol != kNetworkProtocol || hello.schema != wire_schema_hash())
    return refuse(text("another version: this is ", options.version, " with protocol ", kNetworkProtocol,
                       ", the hand's is ", hello.version, " with protocol ", hello.protocol,
                       hello.protocol == kNetworkProtocol ? " and other messages" : "",
                       "; take the same on both sides"));
  if (hand && hand->has_begun() && !hand->is_silent() && hand->peer() != request.peer) return refuse(kTaken);
  if (hand && hand->peer() == request.peer && !hand->has_begun()) return send_welcome();  // it did not hear
  if (hand) end(hand->peer() == request.peer ? "it began again" : "nothing was heard of it", told);
  auto next = std::make_unique<ServedHand>(scene, options.address, control.port(), request.peer, request.address);
  {
    const std::scoped_lock lock(looking);
    hand = std::move(next);
  }
  send_welcome();
  say(text(request.address, " connected", request.key.empty() ? "" : " with key " + request.key));
}

void BodyServer::Parts::begin(const Begin& message) {
  if (message.session != hand->id() || hand->has_begun()) return hand->count_wrong();
  try {
    control.send(hand->peer(), encode(hand->begin(message)));
  } catch (const std::exception& e) {
    control.send(hand->peer(), encode(Bye{e.what()}));
    end(e.what(), told);
  }
}

void BodyServer::Parts::answer(const ControlServer::Request& request) {
  const auto message = decode_control(request.bytes);
  if (const auto* hello = message ? std::get_if<Hello>(&*message) : nullptr) return welcome(request, *hello);
  if (!hand || hand->peer() != request.peer) return;  // of a session that is over
  hand->alive();
  if (!message) return hand->count_wrong();
  if (const auto* m = std::get_if<Begin>(&*message)) return begin(*m);
  if (const auto* m = std::get_if<SetRequest>(&*message)) {
    control.send(request.peer, encode(hand->set(*m)));
  } else if (std::holds_alternative<End>(*message)) {
    end("it ended", told);
  } else if (!std::holds_alternative<Ping>(*message)) {
    hand->count_wrong();
  }
}

void BodyServer::Parts::end(const std::string& reason, const std::function<void(const ServedSession&)>& ended) {
  const std::scoped_lock lock(looking);
  hand->end();
  forward_records();
  control.send(hand->peer(), encode(Bye{reason}));
  hand->ended().reason = reason;
  say(text(hand->result().peer, " left: ", reason));
  if (ended) ended(hand->result());
  hand.reset();
}

void BodyServer::run(const std::function<void(const ServedSession&)>& ended) {
  Parts& p = *parts_;
  int sessions = 0;
  p.told = [&](const ServedSession& s) {
    ++sessions;
    if (ended) ended(s);
  };
  auto next_look = Clock::now(), next_ping = next_look;
  while (!(p.options.stop && p.options.stop->load()) && !(p.options.once && sessions > 0)) {
    const bool is_busy = p.hand && p.hand->has_begun();
    if (is_busy) p.hand->pump(500us);
    if (is_busy && Clock::now() < next_look) continue;
    next_look = Clock::now() + 5ms;
    while (const auto request = p.control.poll(p.hand ? 0 : 50)) p.answer(*request);
    if (p.hand && !p.hand->has_begun()) std::this_thread::sleep_for(2ms);
    for (const Refusal& r : p.control.take_refusals())
      p.say(text(r.address, " refused: key ", r.key, " is not in --authorized"));
    if (!p.hand) continue;
    p.forward_records();
    if (Clock::now() >= next_ping) {  // a large body says nothing else for a while
      p.control.send(p.hand->peer(), encode(Ping{}));
      next_ping = Clock::now() + 500ms;
    }
    if (const std::string error = p.hand->error(); !error.empty())
      p.end(error, p.told);
    else if (p.hand->is_silent())
      p.end("nothing was heard of it", p.told);
  }
  if (p.hand) p.end("the server was stopped", p.told);
}

bool BodyServer::look(VectorX& x, LocalReport& tools, TouchStatus& status) const {
  const std::scoped_lock lock(parts_->looking);
  return parts_->hand && parts_->hand->look(x, tools, status);
}

}  // namespace kt
