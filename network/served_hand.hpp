#pragma once
#include <atomic>
#include <chrono>
#include <mutex>
#include <thread>

#include "haptics/options/band_powers.hpp"
#include "haptics/refresh/touch_parts.hpp"
#include "haptics/setup/built_scene.hpp"
#include "network/body_end.hpp"
#include "network/body_server.hpp"
#include "network/channel/parity.hpp"
#include "network/channel/rate_control.hpp"
#include "network/datagram_port.hpp"

namespace kt {

/// One hand's time with the body: its own key, thread and body at rest.
class ServedHand final : public ModelObserver {
  using Clock = std::chrono::steady_clock;

 public:
  ServedHand(const BuiltScene& scene, const std::string& address, int port, std::string peer, std::string name)
      : scene_(scene),
        peer_(std::move(peer)),
        id_(new_session_id()),
        key_(new_seal_key()),
        port_(UdpSocket::bound(address, port), key_, Direction::to_hand),
        spread_s_(0.5 / scene.options().global.rate_hz) {
    ended_.peer = std::move(name);
    limits_.tools = static_cast<int>(scene.options().tools.size());
    limits_.triangles = static_cast<int>(scene.surface().triangles.size());
    limits_.nodes = scene.model().mesh().num_nodes();
    const ContactSettings& contact = scene.options().contact;
    limits_.facets_per_triangle = contact.surface == "flat" ? 1 : 1 << (2 * contact.surface_levels);
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
    options.motion = message.motion ? std::make_shared<const BandPowers>(*message.motion) : nullptr;
    body_ = std::make_unique<BodyEnd>(scene_.body(), options, this);
    const FirstModel first{encode(body_->begin(message.tools))};
    thread_ = std::thread([this] { refresh(); });
    heard_ = Clock::now();
    ended_.begun = true;
    return first;
  }

  /// Waits for datagrams and sends what is ready, no longer than that.
  void pump(std::chrono::microseconds timeout) {
    send_model();
    const auto message = port_.poll(timeout);
    if (!message || !body_) return;
    heard_ = Clock::now();
    if (message->kind == static_cast<std::uint8_t>(DatagramKind::alive)) return port_.send(DatagramKind::alive, {}, -1);
    hears_ = true;
    if (message->kind == static_cast<std::uint8_t>(DatagramKind::reports)) {
      auto reports = decode_reports(message->bytes, limits_);
      if (!reports) return count_wrong();
      ended_.ticks = std::max(ended_.ticks, reports->batch.last() + 1);
      rate_.told(reports->feedback, port_.num_sealed(), heard_);
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
  /// A hand that builds its half of the body, or takes in the first local model, says nothing for a while.
  bool is_silent() const { return Clock::now() - heard_ > (!body_ ? kBuilding : hears_ ? kSilence : kStarting); }
  void alive() { heard_ = Clock::now(); }

  /// Why the body's simulation ended; empty: it goes on.
  std::string error() const {
    const std::scoped_lock lock(guard_);
    return error_;
  }
  SetReply set(const SetRequest& m) {
    try {
      if (!body_) throw InputError(m.key + ": not before the first tick");
      if (m.key == "contact.surface")  // the hand's computer would go on with its own
        throw InputError("contact.surface: stays as it is over a network; set it in the scene");
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
        body_->wait(std::chrono::milliseconds(5));
        auto model = body_->refresh_if_due();
        if (!model) continue;
        {
          const std::scoped_lock lock(guard_);
          model->loss = loss_;
        }
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
    std::optional<Bytes> bytes;
    {
      const std::scoped_lock lock(guard_);
      loss_ = port_.loss();
      if (port_.is_spreading(DatagramKind::model)) return;  // whole models, if fewer: the newest waits
      bytes = std::exchange(ready_, {});
    }
    if (!bytes) return;
    if (bytes->size() > kMostMessageBytes) {
      const std::scoped_lock lock(guard_);
      error_ = text("a local model has ", bytes->size(), " bytes, more than ", kMostMessageBytes,
                    " do not travel; set link.basis_bits 8, local.reducer krylov or a smaller tool");
      return;
    }
    const double unknown = std::min(loss_for_parity(body_->model_loss(), port_.loss()), kLossUntilKnown);
    port_.spread(DatagramKind::model, std::move(*bytes), rate_.chance_loss().value_or(unknown), spread_s_,
                 rate_.limit());
  }

  static constexpr std::chrono::seconds kBuilding{120}, kStarting{20}, kSilence{3};  // after each it is gone
  const BuiltScene& scene_;
  std::string peer_;
  std::uint64_t id_;
  SealKey key_;
  DatagramPort port_;
  RateControl rate_;
  double spread_s_;  // of a model: half a usual interval
  WireLimits limits_;
  std::unique_ptr<BodyEnd> body_;
  ServedSession ended_;
  Clock::time_point heard_;
  bool hears_ = false;  // datagrams have come
  std::atomic<bool> stop_{false};
  mutable std::mutex guard_;  // of what follows
  std::vector<RefreshRecord> records_;
  std::optional<Bytes> ready_;
  std::optional<double> loss_;  // of datagrams from the hand
  std::string error_;
  std::thread thread_;
};

}  // namespace kt
