#include "tests/fakes/haply_service.hpp"

#include <utility>  // Boost 1.74's awaitable.hpp forgets it

#include <poll.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <cmath>
#include <deque>
#include <list>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "haptics/device/hand_motion.hpp"

namespace kt {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using boost::asio::ip::tcp;
using boost::system::error_code;
using nlohmann::json;
using Request = http::request<http::string_body>;

json xyz(const Vec3& v) { return {{"x", v.x()}, {"y", v.y()}, {"z", v.z()}}; }
json wxyz(const Quaternion& q) { return {{"w", q.w()}, {"x", q.x()}, {"y", q.y()}, {"z", q.z()}}; }
json placed(double scale) {
  return {{"position", xyz(Vec3::Zero())},
          {"rotation", wxyz(Quaternion::Identity())},
          {"scale", xyz(Vec3(scale, scale, scale))}};
}

double seconds() {
  return 1e-9 * static_cast<double>(std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1));
}

/// Where clients come in: each gets a thread.
class Door {
 public:
  Door(unsigned short port, std::function<void(tcp::socket&&)> serve) : serve_(std::move(serve)), acceptor_(context_) {
    const tcp::endpoint here(boost::asio::ip::address_v4::loopback(), port);
    acceptor_.open(here.protocol());
    acceptor_.set_option(tcp::acceptor::reuse_address(true));
    acceptor_.bind(here);
    acceptor_.listen();
    acceptor_.non_blocking(true);
    port_ = acceptor_.local_endpoint().port();
    thread_ = std::thread([this] { run(); });
  }
  ~Door() {
    is_over_ = true;
    thread_.join();
    for (std::thread& guest : guests_) guest.join();
  }
  unsigned short port() const { return port_; }

 private:
  void run() {
    while (!is_over_) {
      error_code failed;
      tcp::socket socket(context_);
      acceptor_.accept(socket, failed);
      if (failed) {
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        continue;
      }
      socket.non_blocking(false);
      socket.set_option(tcp::no_delay(true));
      const timeval limit{0, 500'000};
      ::setsockopt(socket.native_handle(), SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
      guests_.emplace_back([this, plain = std::move(socket)]() mutable {
        try {
          serve_(std::move(plain));
        } catch (const std::exception&) {
          // The client has gone.
        }
      });
    }
  }

  std::function<void(tcp::socket&&)> serve_;
  boost::asio::io_context context_;
  tcp::acceptor acceptor_;
  unsigned short port_ = 0;
  std::atomic<bool> is_over_{false};
  std::list<std::thread> guests_;
  std::thread thread_;
};

/// What a client has configured, or a desk program in its place.
struct Session {
  double mount = 1, transform = 1, gate = 0.3;  // scales; gain
  std::string basis = "XYZ", preset = "defaults";
};

}  // namespace

struct FakeHaply::Parts {
  explicit Parts(FakeHaplyOptions o) : options(std::move(o)), began(seconds()) {
    if (!options.target) options.target = [](double) { return Vec3(0, -0.12, 0.15); };
    x = options.target(0);
    if (options.has_events) events = std::make_unique<Door>(0, [this](tcp::socket&& s) { tell_events(std::move(s)); });
    states = std::make_unique<Door>(options.port, [this](tcp::socket&& s) { receive(std::move(s)); });
    options.port = states->port();
  }
  ~Parts() {
    is_over = true;
    states.reset();
    events.reset();
  }

  /// HTTP and the WebSocket of states share a port.
  void receive(tcp::socket&& plain) {
    if (is_dead) return;
    beast::flat_buffer buffer;
    Request request;
    http::read(plain, buffer, request);
    if (!websocket::is_upgrade(request)) return answer(plain, request);
    websocket::stream<tcp::socket> socket(std::move(plain));
    socket.accept(request);
    talk(socket);
  }

  void answer(tcp::socket& socket, const Request& request) {
    if (!options.has_http) return;
    http::response<http::string_body> out(http::status::ok, request.version());
    const std::string path(request.target());
    if (path == "/settings/devices/force_scale")
      out.body() = json{{"ok", true}, {"data", options.force_scale}}.dump();
    else if (path == "/settings/communication/events/port")
      out.body() = json{{"ok", true}, {"data", events ? events->port() : 1}}.dump();
    else
      out.result(http::status::not_found);
    out.prepare_payload();
    http::write(socket, out);
  }

  void tell_events(tcp::socket&& plain) {
    websocket::stream<tcp::socket> socket(std::move(plain));
    socket.accept();
    std::size_t told = 0;
    {
      const std::scoped_lock lock(mutex);
      told = said.size();
    }
    ++listeners;
    try {
      while (!is_over) {
        std::string next;
        {
          const std::scoped_lock lock(mutex);
          if (told < said.size()) next = said[told++];
        }
        if (!next.empty()) socket.write(boost::asio::buffer(next));
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
      }
    } catch (const std::exception&) {
      // The listener has gone.
    }
    --listeners;
  }

  void talk(websocket::stream<tcp::socket>& socket) {
    ++connections;
    Session session;
    socket.write(boost::asio::buffer(message(true, session)));
    beast::flat_buffer buffer;
    while (!is_over && !is_dead) {
      pollfd waits{socket.next_layer().native_handle(), POLLIN, 0};
      if (buffer.size() == 0 && ::poll(&waits, 1, 20) == 0) continue;
      socket.read(buffer);
      const std::string text = beast::buffers_to_string(buffer.data());
      buffer.consume(buffer.size());
      if (const int wait = hang_ms.exchange(0); wait > 0) std::this_thread::sleep_for(std::chrono::milliseconds(wait));
      const bool is_full = hear(text, session);
      if (fault == HaplyFault::silent) continue;
      std::string out = message(is_full, session);
      if (fault == HaplyFault::truncated) out.resize(out.size() / 2);
      socket.write(boost::asio::buffer(out));
    }
  }

  /// @returns whether all is asked for
  bool hear(const std::string& text, Session& session) {
    const json all = json::parse(text);
    const std::scoped_lock lock(mutex);
    const double t = seconds() - began;
    step(t);
    if (const auto basis = find(all, "/session/configure/basis/permutation")) session.basis = *basis;
    const auto device = find(all, "/inverse3/0");
    if (device) configure(*device, session);
    if (fault == HaplyFault::scaled && is_news) {
      session.mount = 2;
      is_news = false;
    }
    const auto force = device ? find(*device, "/commands/set_cursor_force") : std::nullopt;
    if (force)
      command(*force, t);
    else
      ++heard_sum.questions;
    return find(all, "/session/force_render_full_state").has_value();
  }

  static std::optional<json> find(const json& all, const char* path) {
    const json::json_pointer at(path);
    return all.contains(at) ? std::optional<json>(all[at]) : std::nullopt;
  }

  static void configure(const json& device, Session& session) {
    if (const auto preset = find(device, "/configure/preset/preset")) session.preset = *preset;
    if (const auto scale = find(device, "/configure/mount/transform/scale/x")) {
      session.mount = *scale;
      session.preset = "custom";
    }
    if (const auto scale = find(device, "/commands/set_transform/transform/scale/x")) session.transform = *scale;
    if (const auto gain = find(device, "/configure/force_gate/gain")) session.gate = *gain;
  }

  void command(const json& force, double t) {
    const char* const name = options.knows_vector && force.contains("vector")   ? "vector"
                             : options.knows_values && force.contains("values") ? "values"
                                                                                : nullptr;
    if (!name) {
      ++heard_sum.unknown;
      return;
    }
    if (fault == HaplyFault::deaf) return;
    const json& f = force[name];
    const Vec3 told(f["x"].get<double>(), f["y"].get<double>(), f["z"].get<double>());
    if (heard.empty()) first_heard = t;
    const auto tick = static_cast<long long>(t / options.tick);
    sum = tick == last_tick ? Vec3(sum + told) : told;
    last_tick = tick;
    commanded = told;
    on_the_way.push_back({t + options.delay, options.force_scale * sum});
    if (!heard.empty()) heard_sum.most_step = std::max(heard_sum.most_step, (told - heard.back().force).norm());
    heard.push_back({t, told});
    ++heard_sum.messages;
    heard_sum.last = told.norm();
    heard_sum.most_force = std::max(heard_sum.most_force, told.norm());
    heard_sum.most_in_a_tick = std::max(heard_sum.most_in_a_tick, sum.norm());
    heard_sum.is_finite = heard_sum.is_finite && told.allFinite();
    if (heard.size() >= options.most_kept)
      heard.erase(heard.begin(), heard.begin() + static_cast<std::ptrdiff_t>(heard.size() / 2));
  }

  /// The hand waits for the first force that can be felt.
  Vec3 target_at(double t) const { return options.target(std::max(0.0, t - first_heard)); }

  /// The hand, with the forces that have reached the motors by then.
  void step(double until) {
    constexpr double kStep = 2e-4;
    while (at < until) {
      const double next = std::min(at + kStep, until), h = next - at;
      while (!on_the_way.empty() && on_the_way.front().t <= at) {
        acting = on_the_way.front().force;
        on_the_way.pop_front();
      }
      const HandMotion motion(options.mass, options.damping, options.stiffness, h);
      const Vec3 from = target_at(at), target = target_at(next), before = x;
      const Vec3 drift = (target - from) / h;
      Vec3 y = x - from, w = v - drift;
      motion.step(y, w, acting);
      x = target + y;
      v = w + drift;
      given += acting.dot(x - before);
      most_given = std::max(most_given, given);
      at = next;
    }
  }

  json config_json(const Session& session) const {
    if (options.is_old) return {{"device_info", {{"model", "Inverse3 (fake)"}, {"major_version", 3}}}};
    const std::string& kept = options.kept;
    return {
        {"type", options.type},
        {"device_info", {{"major_version", 7}, {"minor_version", 4}, {"device_type", 4}}},
        {"preset", kept == "preset" ? "led_front" : session.preset},
        {"basis", {{"permutation", kept == "basis" ? "XZY" : session.basis}}},
        {"mount", placed(kept == "mount" ? 2 : session.mount)},
        {"filters", {{"force_gate", {{"gain", kept == "gate" ? 0.3 : session.gate}}}, {"damping", {{"scalar", 0.0}}}}}};
  }

  json device_json(const std::string& id, bool is_full, const Session& session) const {
    json device = {{"device_id", id}};
    if (is_full) device["config"] = config_json(session);
    Vec3 shown = x;
    if (options.encoder_step > 0) shown = (x / options.encoder_step).array().round().matrix() * options.encoder_step;
    device["state"] = {{"cursor_position", xyz(session.mount * shown)},
                       {"cursor_velocity", xyz(session.mount * v)},
                       {"body_orientation", wxyz(Quaternion::Identity())},
                       {"control_domain", "cartesian"},
                       {"transform", placed(options.kept == "transform" ? 2 : session.transform)}};
    if (options.repeats)
      device["state"]["current_cursor_force"] = xyz((fault == HaplyFault::saturated ? 0.1 : 1) * commanded);
    if (fault == HaplyFault::deaf) device["state"]["current_cursor_force"] = xyz(Vec3::Zero());
    if (fault == HaplyFault::nan) device["state"]["cursor_position"]["z"] = nullptr;  // what JSON makes of NaN
    device["status"] = {{"calibrated", fault != HaplyFault::uncalibrated},
                        {"power_supply", fault != HaplyFault::unpowered},
                        {"ready", fault != HaplyFault::not_ready},
                        {"started", options.is_started},
                        {"in_use", options.is_in_use}};
    return device;
  }

  std::string message(bool is_full, const Session& session) {
    const std::scoped_lock lock(mutex);
    step(seconds() - began);
    json out;
    out["session_id"] = 7;
    out["inverse3"] = json::array();
    for (const std::string& id : options.ids)
      if (fault != HaplyFault::no_device) out["inverse3"].push_back(device_json(id, is_full, session));
    out["wireless_verse_grip"] = json::array();
    for (const FakeGrip& grip : options.grips) {
      json one = {
          {"device_id", grip.id},
          {"state", {{"orientation", wxyz(grip.turn)}, {"buttons", {{"a", true}, {"b", false}, {"c", false}}}}}};
      if (is_full && !grip.paired.empty()) one["config"] = {{"paired_inverse3", grip.paired}};
      out["wireless_verse_grip"].push_back(one);
    }
    return out.dump();
  }

  FakeHaplyOptions options;
  std::atomic<bool> is_over{false}, is_dead{false}, is_news{false};
  std::atomic<int> hang_ms{0}, connections{0}, listeners{0};
  std::atomic<HaplyFault> fault{HaplyFault::none};
  mutable std::mutex mutex;
  double began, at = 0, first_heard = std::numeric_limits<double>::infinity();
  Vec3 x = Vec3::Zero(), v = Vec3::Zero(), acting = Vec3::Zero(), commanded = Vec3::Zero(), sum = Vec3::Zero();
  long long last_tick = -1;
  double given = 0, most_given = 0;
  std::deque<HeardForce> on_the_way;
  std::vector<HeardForce> heard;
  std::vector<std::string> said;
  HeardSum heard_sum;
  std::unique_ptr<Door> events, states;
};

FakeHaply::FakeHaply(FakeHaplyOptions options) : parts_(std::make_unique<Parts>(std::move(options))) {}
FakeHaply::~FakeHaply() = default;
unsigned short FakeHaply::port() const { return parts_->options.port; }
std::string FakeHaply::address() const { return "ws://localhost:" + std::to_string(port()); }
void FakeHaply::set_fault(HaplyFault fault) {
  parts_->is_news = true;
  parts_->fault = fault;
}
void FakeHaply::hang(int milliseconds) { parts_->hang_ms = milliseconds; }
void FakeHaply::die() { parts_->is_dead = true; }
void FakeHaply::live() { parts_->is_dead = false; }
void FakeHaply::send_event(const std::string& json) {
  const std::scoped_lock lock(parts_->mutex);
  parts_->said.push_back(json);
}
int FakeHaply::listeners() const { return parts_->listeners; }
double FakeHaply::now() const { return seconds() - parts_->began; }
int FakeHaply::connections() const { return parts_->connections; }
std::vector<HeardForce> FakeHaply::heard() const {
  const std::scoped_lock lock(parts_->mutex);
  return parts_->heard;
}
HeardSum FakeHaply::heard_sum() const {
  const std::scoped_lock lock(parts_->mutex);
  return parts_->heard_sum;
}
Vec3 FakeHaply::place() const {
  const std::scoped_lock lock(parts_->mutex);
  return parts_->x;
}
double FakeHaply::most_energy_given() const {
  const std::scoped_lock lock(parts_->mutex);
  return parts_->most_given;
}

}  // namespace kt
