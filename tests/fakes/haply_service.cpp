#include "tests/fakes/haply_service.hpp"

#include <utility>  // Boost 1.74's awaitable.hpp forgets it

#include <poll.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <cmath>
#include <deque>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "haptics/device/hand_motion.hpp"

namespace kt {
namespace {

namespace beast = boost::beast;
namespace websocket = beast::websocket;
using boost::asio::ip::tcp;
using boost::system::error_code;
using nlohmann::json;

json xyz(const Vec3& v) { return {{"x", v.x()}, {"y", v.y()}, {"z", v.z()}}; }

double seconds() {
  return 1e-9 * static_cast<double>(std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1));
}

}  // namespace

struct FakeHaply::Parts {
  explicit Parts(FakeHaplyOptions o) : options(std::move(o)), acceptor(context), began(seconds()) {
    if (!options.target) options.target = [](double) { return Vec3(0, -0.12, 0.15); };
    x = options.target(0);
    const tcp::endpoint here(boost::asio::ip::address_v4::loopback(), options.port);
    acceptor.open(here.protocol());
    acceptor.set_option(tcp::acceptor::reuse_address(true));
    acceptor.bind(here);
    acceptor.listen();
    options.port = acceptor.local_endpoint().port();
    acceptor.non_blocking(true);
    thread = std::thread([this] { serve(); });
  }
  ~Parts() {
    is_over = true;
    thread.join();
  }

  void serve() {
    while (!is_over) {
      error_code failed;
      tcp::socket socket(context);
      acceptor.accept(socket, failed);
      if (failed || is_dead) {
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        continue;
      }
      try {
        talk(std::move(socket));
      } catch (const std::exception&) {
        // The client has gone.
      }
    }
  }

  void talk(tcp::socket&& plain) {
    plain.non_blocking(false);
    plain.set_option(tcp::no_delay(true));
    const timeval limit{0, 20'000};  // so that the end of the service is seen
    ::setsockopt(plain.native_handle(), SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    websocket::stream<tcp::socket> socket(std::move(plain));
    socket.accept();
    ++connections;
    socket.write(boost::asio::buffer(message(true)));
    beast::flat_buffer buffer;
    while (!is_over && !is_dead) {
      pollfd waits{socket.next_layer().native_handle(), POLLIN, 0};
      if (buffer.size() == 0 && ::poll(&waits, 1, 20) == 0) continue;
      socket.read(buffer);
      const std::string text = beast::buffers_to_string(buffer.data());
      buffer.consume(buffer.size());
      if (const int wait = hang_ms.exchange(0); wait > 0) std::this_thread::sleep_for(std::chrono::milliseconds(wait));
      hear(text);
      if (fault == HaplyFault::silent) continue;
      std::string out = message(false);
      if (fault == HaplyFault::truncated) out.resize(out.size() / 2);
      socket.write(boost::asio::buffer(out));
    }
  }

  void hear(const std::string& text) {
    const json all = json::parse(text);
    const std::scoped_lock lock(mutex);
    const double t = seconds() - began;
    step(t);
    if (!all.contains("inverse3")) return;
    const json& force = all["inverse3"][0]["commands"]["set_cursor_force"]["values"];
    const Vec3 told(force["x"].get<double>(), force["y"].get<double>(), force["z"].get<double>());
    if (heard.empty()) first_heard = t;
    on_the_way.push_back({t + options.delay, told});
    if (!heard.empty()) heard_sum.most_step = std::max(heard_sum.most_step, (told - heard.back().force).norm());
    heard.push_back({t, told});
    ++heard_sum.messages;
    heard_sum.last = told.norm();
    heard_sum.most_force = std::max(heard_sum.most_force, told.norm());
    heard_sum.is_finite = heard_sum.is_finite && told.allFinite();
    if (heard.size() >= options.most_kept)
      heard.erase(heard.begin(), heard.begin() + static_cast<std::ptrdiff_t>(heard.size() / 2));
  }

  /// The hand waits for the first force.
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

  std::string message(bool is_inventory) {
    const std::scoped_lock lock(mutex);
    step(seconds() - began);
    json out;
    out["session_id"] = 7;
    out["inverse3"] = json::array();
    for (const std::string& id : options.ids) {
      if (fault == HaplyFault::no_device) break;
      Vec3 shown = x;
      if (options.encoder_step > 0) shown = (x / options.encoder_step).array().round().matrix() * options.encoder_step;
      json device = {{"device_id", id}};
      if (is_inventory) device["config"] = {{"device_info", {{"model", "Inverse3 (fake)"}, {"major_version", 3}}}};
      device["state"] = {{"cursor_position", xyz(shown)},
                         {"cursor_velocity", xyz(v)},
                         {"current_cursor_force", xyz(acting)},
                         {"body_orientation", {{"w", 1}, {"x", 0}, {"y", 0}, {"z", 0}}},
                         {"control_domain", "cartesian"}};
      if (fault == HaplyFault::saturated) device["state"]["current_cursor_force"] = xyz(0.1 * acting);
      if (fault == HaplyFault::nan) device["state"]["cursor_position"]["z"] = nullptr;  // what JSON makes of NaN
      device["status"] = {{"calibrated", fault != HaplyFault::uncalibrated}};
      out["inverse3"].push_back(device);
    }
    out["wireless_verse_grip"] = json::array({{{"device_id", "61"},
                                               {"state",
                                                {{"orientation", {{"w", 1.0}, {"x", 0.0}, {"y", 0.0}, {"z", 0.0}}},
                                                 {"buttons", {{"a", is_held.load()}, {"b", false}, {"c", false}}}}}}});
    return out.dump();
  }

  FakeHaplyOptions options;
  boost::asio::io_context context;
  tcp::acceptor acceptor;
  std::atomic<bool> is_over{false}, is_dead{false}, is_held{true};
  std::atomic<int> hang_ms{0}, connections{0};
  std::atomic<HaplyFault> fault{HaplyFault::none};
  mutable std::mutex mutex;
  double began, at = 0, first_heard = std::numeric_limits<double>::infinity();
  Vec3 x = Vec3::Zero(), v = Vec3::Zero(), acting = Vec3::Zero();
  double given = 0, most_given = 0;
  std::deque<HeardForce> on_the_way;
  std::vector<HeardForce> heard;
  HeardSum heard_sum;
  std::thread thread;
};

FakeHaply::FakeHaply(FakeHaplyOptions options) : parts_(std::make_unique<Parts>(std::move(options))) {}
FakeHaply::~FakeHaply() = default;
unsigned short FakeHaply::port() const { return parts_->options.port; }
std::string FakeHaply::address() const { return "ws://localhost:" + std::to_string(port()); }
void FakeHaply::set_fault(HaplyFault fault) { parts_->fault = fault; }
void FakeHaply::hang(int milliseconds) { parts_->hang_ms = milliseconds; }
void FakeHaply::die() { parts_->is_dead = true; }
void FakeHaply::live() { parts_->is_dead = false; }
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
