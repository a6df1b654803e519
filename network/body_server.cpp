#include "network/body_server.hpp"

#include <chrono>
#include <thread>

#include "core/base/loopback.hpp"
#include "core/body/state.hpp"
#include "haptics/remote/model_unpacker.hpp"
#include "network/control/control_server.hpp"
#include "network/refusal_log.hpp"
#include "network/served_hand.hpp"

namespace kt {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr std::size_t kMostRequest = std::size_t{1} << 16;   // bytes of what a hand says at once
constexpr std::size_t kMostWelcome = std::size_t{60} << 20;  // of what a hand takes (ControlClientOptions::most_bytes)
constexpr std::size_t kMostUnread = 4;                       // hands that have not read what they were sent

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

struct BodyServer::Parts {
  Parts(const BuiltScene& touched, std::string scene_json, std::vector<Welcome::File> sent, const BodyServerOptions& o,
        Say tell)
      : scene(touched),
        json(std::move(scene_json)),
        files(std::move(sent)),
        options(o),
        say([tell = std::move(tell)](const std::string& line) { tell(one_line(line)); }),
        refusals(say),
        control({.address = o.address,
                 .port = o.port,
                 .own = o.own,
                 .authorized = o.authorized,
                 .most_bytes = kMostRequest}),
        hash(body_hash(touched.body())) {}

  const BuiltScene& scene;
  std::string json;
  std::vector<Welcome::File> files;
  BodyServerOptions options;
  Say say;
  RefusalLog refusals;
  ControlServer control;
  std::uint64_t hash;
  mutable std::mutex looking;        // of `hand` itself, for look()
  std::unique_ptr<ServedHand> hand;  // who touches the body
  // Hands that were sent the scene with its files, by their session, and did not begin with it: as far as is known
  // these bytes wait here still.
  std::map<std::string, std::uint64_t> unread;
  std::string put_off;  // who was told last that somebody else has the body

  bool is_there(const std::string& peer) { return control.send(peer, encode(Ping{})); }
  bool has_room_for(const std::string& peer);
  bool is_taken_from(const ControlServer::Request& request, const Hello& hello);
  void answer(const ControlServer::Request& request);
  void welcome(const ControlServer::Request& request, const Hello& hello);
  void begin(const ControlServer::Request& request, const Begin& message);
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
  std::size_t bytes = scene_json.size();
  for (const Welcome::File& file : files) bytes += file.bytes.size();
  if (bytes > kMostWelcome)
    throw InputError(text("the scene and its files have ", bytes >> 20, " MiB; at most ", kMostWelcome >> 20,
                          " are sent to a hand: take a coarser mesh"));
  parts_ = std::make_unique<Parts>(scene, std::move(scene_json), std::move(files), options, std::move(say));
}

BodyServer::~BodyServer() = default;

int BodyServer::port() const { return parts_->control.port(); }

/// Whoever does not read what it is sent is sent no more of it, and there are few of these.
bool BodyServer::Parts::has_room_for(const std::string& peer) {
  if (unread.size() >= kMostUnread) std::erase_if(unread, [&](const auto& one) { return !is_there(one.first); });
  return unread.size() < kMostUnread && !unread.contains(peer);
}

/// A hand keeps the body from its greeting on, until it is gone. It may come back over another connection.
bool BodyServer::Parts::is_taken_from(const ControlServer::Request& request, const Hello& hello) {
  if (!hand || hand->peer() == request.peer || hand->id() == hello.session || hand->is_silent()) return false;
  return hand->has_begun() || is_there(hand->peer());
}

void BodyServer::Parts::welcome(const ControlServer::Request& request, const Hello& hello) {
  const auto refuse = [&](const std::string& why) {
    control.send(request.peer, encode(Bye{why}));
    refusals.add(request.address, why, Clock::now());
  };
  if (hello.protocol != kNetworkProtocol || hello.schema != wire_schema_hash())
    return refuse(text("another version: this is ", options.version, " with protocol ", kNetworkProtocol,
                       ", the hand's is ", hello.version, " with protocol ", hello.protocol,
                       hello.protocol == kNetworkProtocol ? " and other messages" : "",
                       "; take the same on both sides"));
  if (is_taken_from(request, hello)) {
    control.send(request.peer, encode(Bye{kTaken}));
    if (std::exchange(put_off, request.peer) != request.peer)  // it asks again and again
      refusals.add(request.address, kTaken, Clock::now());
    return;
  }
  if (hand && hand->peer() == request.peer && !hand->has_begun()) return hand->count_wrong();  // it is on its way
  if (!has_room_for(request.peer)) {
    control.send(request.peer, encode(Bye{kTaken}));
    return refusals.add(request.address, "it, or others, did not read what they were sent", Clock::now());
  }
  const bool is_same = hand && (hand->peer() == request.peer || hand->id() == hello.session);
  if (hand) end(is_same ? "it began again" : "nothing was heard of it", told);
  auto next = std::make_unique<ServedHand>(scene, options.address, control.port(), request.peer, request.address);
  {
    const std::scoped_lock lock(looking);
    hand = std::move(next);
  }
  unread[hand->peer()] = hand->id();
  control.send(hand->peer(), encode(Welcome{hand->id(), hand->key(), control.port(), json, files, hash}));
  say(text(request.address, " connected", request.key.empty() ? "" : " with key " + request.key));
}

void BodyServer::Parts::begin(const ControlServer::Request& request, const Begin& message) {
  const auto sent = unread.find(request.peer);
  if (sent != unread.end() && sent->second == message.session) unread.erase(sent);
  if (!hand || hand->peer() != request.peer || hand->id() != message.session) {
    control.send(request.peer, encode(Bye{kOver}));
    return;
  }
  if (hand->has_begun()) return hand->count_wrong();
  try {
    control.send(hand->peer(), encode(hand->begin(message)));
    say(text(request.address, " has its first local model"));
  } catch (const std::exception& e) {
    control.send(hand->peer(), encode(Bye{e.what()}));
    end(e.what(), told);
  }
}

void BodyServer::Parts::answer(const ControlServer::Request& request) {
  const auto message = decode_control(request.bytes);
  if (const auto* hello = message ? std::get_if<Hello>(&*message) : nullptr) return welcome(request, *hello);
  const bool is_own = hand && hand->peer() == request.peer;
  if (is_own) hand->alive();
  if (const auto* m = message ? std::get_if<Begin>(&*message) : nullptr) return begin(request, *m);
  if (!is_own) return;  // of a session that is over
  if (!message) return hand->count_wrong();
  if (const auto* m = std::get_if<SetRequest>(&*message)) {
    control.send(request.peer, encode(hand->set(*m)));
  } else if (std::holds_alternative<End>(*message)) {
    end(kEnded, told);
  } else if (!std::holds_alternative<Ping>(*message)) {
    hand->count_wrong();
  }
}

void BodyServer::Parts::end(const std::string& reason, const std::function<void(const ServedSession&)>& ended) {
  const std::scoped_lock lock(looking);
  hand->end();
  forward_records();
  control.send(hand->peer(), encode(Bye{one_line(reason)}));
  hand->ended().reason = reason;
  say(text(hand->result().peer, " left: ", reason));
  if (ended) ended(hand->result());
  hand.reset();
}

void BodyServer::run(const std::function<void(const ServedSession&)>& ended) {
  Parts& p = *parts_;
  int sessions = 0;
  p.told = [&](const ServedSession& s) {
    sessions += s.begun;  // a hand that never began may come back
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
      p.refusals.add(r.address, text("key ", r.key, " is not in --authorized"), Clock::now());
    if (!p.hand) continue;
    p.forward_records();
    if (Clock::now() >= next_ping) {  // a large body says nothing else for a while
      const bool is_there = p.is_there(p.hand->peer());
      next_ping = Clock::now() + 500ms;
      if (!is_there && !p.hand->has_begun()) {
        p.end("its connection was closed", p.told);
        continue;
      }
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
