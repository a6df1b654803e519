#include "network/hand_connection.hpp"

#include <chrono>
#include <thread>

#include "core/base/error.hpp"
#include "core/base/loopback.hpp"

namespace kt {
namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr auto kPatience = 60s;  // for the first local model: a large body takes its time

}  // namespace

HandConnection::HandConnection(const HandConnectionOptions& options) : options_(options) {
  if (!is_loopback(options.host) && !options.server_key)
    throw InputError(text(options.host,
                          ": is another computer: keys are needed; make them with kilotouch key new DIR and "
                          "give --keys DIR and --server-key, the public key of the server"));
  control_ = std::make_unique<ControlClient>(ControlClientOptions{
      .host = options.host, .port = options.port, .own = options.own, .server_key = options.server_key});
}

void HandConnection::throw_if_refused() const {
  const std::string where = text(options_.host, ":", options_.port, ": ");
  if (trouble() == ClientTrouble::refused)
    throw InputError(where + "the server does not know this key; add the public key to the file of its --authorized");
  if (trouble() == ClientTrouble::handshake_failed)
    throw InputError(where + (options_.server_key ? "this is not the server of --server-key, or it has no keys"
                                                  : "the server asks for keys; give --keys DIR and --server-key"));
}

bool HandConnection::send(const ControlMessage& message) { return control_->send(encode(message)); }

std::optional<ControlMessage> HandConnection::poll(int timeout_ms) {
  const auto bytes = control_->poll(timeout_ms);
  if (!bytes) return {};
  auto out = decode_control(*bytes);
  wrong_ += !out;
  return out;
}

std::optional<Welcome> HandConnection::try_again() {
  const auto end = Clock::now() + 1s;
  while (Clock::now() < end && !(options_.stop && options_.stop->load())) {
    const auto message = poll(50);
    throw_if_refused();
    ask();
    if (!message) continue;
    if (const auto* bye = std::get_if<Bye>(&*message)) {
      if (bye->reason == kEnded) continue;  // of a session before
      asked_ = 0;
      if (bye->reason != kTaken && bye->reason != kOver) throw InputError(text(place(), ": ", bye->reason));
      put_off_ = bye->reason;
      std::this_thread::sleep_for(500ms);  // perhaps not for long: oneself, before
    } else if (const auto* welcome = std::get_if<Welcome>(&*message)) {
      return *welcome;
    }
  }
  return {};
}

/// Once a connection: a server that came back has not heard of the question before.
void HandConnection::ask(std::uint64_t session) {
  const long now = control_->num_connections();
  if (trouble() != ClientTrouble::none || now == asked_) return;
  if (send(Hello{.version = options_.version, .session = session})) asked_ = now;
}

Welcome HandConnection::greet(const std::function<void(const std::string&)>& say) {
  const auto end = Clock::now() + std::chrono::duration<double>(options_.wait);
  std::string told;
  put_off_.clear();
  for (;;) {
    if (auto welcome = try_again()) return std::move(*welcome);
    if (options_.stop && options_.stop->load()) throw RunError("stopped before the server was there");
    if (Clock::now() >= end)
      throw RunError(put_off_.empty()
                         ? text(place(), ": no kilotouch serve answered in ", options_.wait, " s; is it running there?")
                         : text(place(), ": ", put_off_, "; waited for ", options_.wait, " s (--wait)"));
    const std::string why = text("waiting for ", place(), put_off_.empty() ? "" : ": ", put_off_);
    if (told != why && say) say(why);
    told = why;
  }
}

std::optional<ModelMessage> HandConnection::begin(const Begin& message) {
  if (control_->num_connections() != asked_ || !send(message)) return {};
  const auto end = Clock::now() + kPatience;
  while (Clock::now() < end) {
    if (options_.stop && options_.stop->load()) throw RunError("stopped before the first local model was there");
    const auto answer = poll(100);
    if (trouble() != ClientTrouble::none || control_->num_connections() != asked_) return {};
    if (!answer) continue;
    if (const auto* bye = std::get_if<Bye>(&*answer)) {
      if (bye->reason == kOver) return {};
      throw RunError(text("the body's computer: ", bye->reason));
    }
    if (const auto* first = std::get_if<FirstModel>(&*answer)) {
      auto model = decode_model(first->model);
      if (!model) throw RunError("the first local model of the body's computer is none");
      return model;
    }
  }
  throw RunError(text(place(), ": no local model came in ", kPatience.count(), " s"));
}

std::unique_ptr<DatagramPort> HandConnection::open_port(const Welcome& welcome) const {
  return std::make_unique<DatagramPort>(UdpSocket::connected_to(data_host(), data_port(welcome)), welcome.key,
                                        Direction::to_body);
}

}  // namespace kt
