// Haply Inverse3 by its service: a WebSocket on this computer, JSON both ways, no library of the vendor. After its
// inventory the service sends one state for each message that it gets: our rate is the rate.
#include <utility>  // Boost 1.74's awaitable.hpp forgets it

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "haptics/device/real_time_thread.hpp"
#include "haptics/driver/haply_messages.hpp"
#include "haptics/driver/live_device.hpp"

namespace kt {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;
using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr const char* kAddress = "ws://localhost:10001";
constexpr double kUsualForce = 3;         // [N] limits are in none of the service's messages
constexpr std::size_t kMostOnTheWay = 3;  // messages without an answer: a service that hangs is not flooded

struct ServiceAddress {
  std::string host, port;
};

ServiceAddress parse_address(const std::string& address) {
  const std::string all = address.empty() ? kAddress : address;
  const std::string_view scheme = "ws://";
  const std::size_t colon = all.rfind(':');
  const bool is_plain = all.starts_with(scheme) && colon != std::string::npos && colon > scheme.size() &&
                        colon + 1 < all.size() && all.find_first_not_of("0123456789/", colon + 1) == std::string::npos;
  if (!is_plain)
    throw InputError(text("tool.path.device.address \"", all, "\": must be ws://HOST:PORT, as ", kAddress));
  std::string port = all.substr(colon + 1);
  while (port.ends_with('/')) port.pop_back();
  return {all.substr(scheme.size(), colon - scheme.size()), port};
}

/// One connection: from its handshake until it is lost.
class Connection {
 public:
  Connection(const ServiceAddress& address, std::string id, double service_damping, DeviceSlots& slots,
             const std::atomic<bool>& is_closing)
      : address_(address),
        id_(std::move(id)),
        service_damping_(service_damping),
        slots_(slots),
        is_closing_(is_closing),
        socket_(context_),
        timer_(context_) {}

  /// Throws boost::system::system_error.
  void open() {
    tcp::resolver resolver(context_);
    auto& stream = beast::get_lowest_layer(socket_);
    const auto found = resolver.resolve(address_.host, address_.port);
    stream.expires_after(milliseconds(2000));
    error_code failed = asio::error::would_block;
    stream.async_connect(found, [&](error_code e, const tcp::endpoint&) { failed = e; });
    settle(failed);
    stream.socket().set_option(tcp::no_delay(true));
    stream.expires_never();
    socket_.set_option(websocket::stream_base::timeout{milliseconds(2000), milliseconds(5000), false});
    socket_.read_message_max(1 << 20);
    failed = asio::error::would_block;
    socket_.async_handshake(address_.host, "/", [&](error_code e) { failed = e; });
    settle(failed);
  }

  /// The inventory: sent first, and asked for at 1 Hz while it is empty. @param patience [ms]
  HaplyState inventory(int patience) {
    for (int waited = 0;; waited += 100) {
      error_code failed = asio::error::would_block;
      std::size_t bytes = 0;
      socket_.async_read(buffer_, [&](error_code e, std::size_t n) {
        failed = e;
        bytes = n;
      });
      context_.restart();
      const auto until = std::chrono::steady_clock::now() + milliseconds(patience - waited);
      while (failed == asio::error::would_block && std::chrono::steady_clock::now() < until && !is_closing_)
        context_.run_one_for(milliseconds(20));
      if (failed == asio::error::would_block) {
        beast::get_lowest_layer(socket_).close();
        throw boost::system::system_error(asio::error::timed_out);
      }
      if (failed) throw boost::system::system_error(failed);
      const HaplyState out = read_haply_state(take_text(), id_);
      if (!out.devices.empty() || waited >= patience) return out;
      std::this_thread::sleep_for(milliseconds(100));
      socket_.write(asio::buffer(haply_question()));
    }
  }

  /// Until the connection is lost, or the driver closes. Zeros are written for 50 ms then.
  void run(const std::string& id) {
    id_ = id;
    send(haply_greeting(id_, service_damping_));
    read();
    schedule(microseconds(0));
    context_.restart();
    context_.run();
  }

 private:
  /// Runs until `failed` is set; throws what it is.
  void settle(const error_code& failed) {
    context_.restart();
    while (failed == asio::error::would_block && context_.run_one() > 0) {
    }
    if (failed) throw boost::system::system_error(failed);
  }

  std::string take_text() {
    std::string out = beast::buffers_to_string(buffer_.data());
    buffer_.consume(buffer_.size());
    return out;
  }

  void read() {
    socket_.async_read(buffer_, [this](error_code e, std::size_t) {
      if (e) return end();
      const std::int64_t now = monotonic_ns();
      if (on_the_way_ > 0) --on_the_way_;
      heard_ns_ = now;
      take(take_text(), now);
      read();
    });
  }

  void take(const std::string& message, std::int64_t now) {
    HaplyState state;
    try {
      state = read_haply_state(message, id_);
    } catch (const InputError&) {
      return;  // a frame that is none: the pose ages
    }
    if (!state.is_calibrated)
      slots_.health = DeviceHealth::uncalibrated;
    else if (state.x)
      slots_.health = DeviceHealth::ok;
    if (!state.x) return;
    DeviceReading out = reading_;
    for (int i = 0; i < 3; ++i) {
      out.x[i] = (*state.x)[i];
      out.v[i] = state.v ? (*state.v)[i] : std::numeric_limits<double>::quiet_NaN();
    }
    if (state.turn) {
      out.turn[0] = state.turn->w();
      for (int i = 0; i < 3; ++i) out.turn[i + 1] = state.turn->vec()[i];
    }
    out.buttons = state.buttons;
    out.at_ns = now;
    ++out.count;
    if (state.force) measure_delay(*state.force, now, out);
    reading_ = out;
    slots_.reading.put(out);
  }

  /// The force that acts now was sent some time ago: it is told apart by its value.
  void measure_delay(const Vec3& acting, std::int64_t now, DeviceReading& out) {
    constexpr double kSame = 1e-4;  // [N] the service rounds
    for (std::size_t back = 0; back < sent_.size() - 1 && back + 1 < sends_; ++back) {
      const std::size_t i = sends_ - 1 - back;
      if (i <= acknowledged_) return;
      const Sent &it = sent_[i % sent_.size()], &before = sent_[(i - 1) % sent_.size()];
      if ((it.force - acting).norm() > kSame) continue;
      if ((it.force - before.force).norm() < 4 * kSame) continue;  // not told apart from the one before
      acknowledged_ = i;
      if (it.order_ns == 0) return;
      out.delay = 1e-9 * static_cast<double>(now - it.order_ns);
      ++out.delays;
      return;
    }
  }

  void schedule(microseconds wait) {
    timer_.expires_after(wait);
    timer_.async_wait([this](error_code e) {
      if (!e) tick();
    });
  }

  /// After each order at once, and again so long before the next one that its answer is a fresh pose then.
  void tick() {
    constexpr std::int64_t kAhead = 300'000, kLook = 60'000, kSlowest = 1'000'000,
                           kGivenUp = 100'000'000;  // [ns]
    const std::int64_t now = monotonic_ns();
    if (is_closing_) return close(now);
    if (now - heard_ns_ > 2'000'000'000 && heard_ns_ != 0) return end();  // it hangs: another connection may do
    DeviceOrder newest;
    const bool is_read = slots_.order.read(newest);
    const bool is_new = is_read && newest.count != last_order_.count;
    if (is_new) {
      if (last_order_.at_ns != 0)
        period_ns_ = std::clamp<std::int64_t>(newest.at_ns - last_order_.at_ns, 100'000, 20'000'000);
      last_order_ = newest;
      asked_ = false;
    }
    const std::int64_t next = last_order_.at_ns + period_ns_;  // when another order is likely
    const bool is_stopped = now - last_order_.at_ns > 2 * period_ns_;
    const bool is_due = is_stopped ? now - sent_ns_ >= kSlowest : !asked_ && now >= next - kAhead;
    if (now - sent_ns_ > kGivenUp) on_the_way_ = 0;  // answers that are this late were never sent
    const bool is_free = on_the_way_ < kMostOnTheWay;
    if ((is_new || is_due) && is_free) {
      if (!is_new) asked_ = true;
      send_force(slots_.wanted(now));
    }
    const std::int64_t wake = is_stopped ? now + kSlowest / 2
                              : asked_   ? std::max(next + kLook / 3, now + kLook)
                                         : next - kAhead;
    schedule(microseconds(std::max<std::int64_t>(kLook, wake - now) / 1000));
  }

  void send_force(const DeviceOrder& order) {
    sent_[sends_++ % sent_.size()] = {Vec3(order.force[0], order.force[1], order.force[2]), order.at_ns};
    send(haply_force(id_, order.force));
  }

  void send(std::string message) {
    sent_ns_ = monotonic_ns();
    if (is_writing_) {
      waiting_ = std::move(message);  // the newest replaces an older one
      return;
    }
    is_writing_ = true;
    ++on_the_way_;
    writing_ = std::move(message);
    socket_.async_write(asio::buffer(writing_), [this](error_code e, std::size_t) {
      is_writing_ = false;
      if (e) return end();
      if (!waiting_.empty()) send(std::exchange(waiting_, {}));
    });
  }

  /// Zeros for 50 ms, whatever the order says; then goodbye.
  void close(std::int64_t now) {
    if (closing_since_ == 0) closing_since_ = now;
    if (now - closing_since_ > 50'000'000) return end();
    send_force({});
    schedule(milliseconds(2));
  }

  void end() {
    if (is_over_) return;
    is_over_ = true;
    timer_.cancel();
    error_code none;
    beast::get_lowest_layer(socket_).socket().shutdown(tcp::socket::shutdown_both, none);
    beast::get_lowest_layer(socket_).close();
    context_.stop();  // the socket's own timers would keep it for seconds
  }

  struct Sent {
    Vec3 force = Vec3::Zero();
    std::int64_t order_ns = 0;
  };

  ServiceAddress address_;
  std::string id_;
  double service_damping_;
  DeviceSlots& slots_;
  const std::atomic<bool>& is_closing_;
  asio::io_context context_;
  websocket::stream<beast::tcp_stream> socket_;
  asio::steady_timer timer_;
  beast::flat_buffer buffer_;
  std::string writing_, waiting_;
  bool is_writing_ = false, is_over_ = false, asked_ = false;
  DeviceReading reading_;
  DeviceOrder last_order_;
  std::array<Sent, 64> sent_;
  std::size_t sends_ = 0, acknowledged_ = 0, on_the_way_ = 0;
  std::int64_t sent_ns_ = 0, heard_ns_ = 0, closing_since_ = 0, period_ns_ = 1'000'000;
};

[[noreturn]] void refuse(const ServiceAddress& address, const std::string& why) {
  throw InputError(text("tool.path.device: ws://", address.host, ":", address.port, ": ", why,
                        "; is the Haply Inverse Service running there?"));
}

/// The id that is meant among those that are there.
std::string choose(const HaplyState& inventory, const std::string& id) {
  if (inventory.devices.empty())
    throw InputError(
        "tool.path.device: the Haply Inverse Service lists no Inverse3; is it plugged in and switched on?");
  if (id.empty() && inventory.devices.size() == 1) return inventory.devices.front();
  if (id.empty())
    throw InputError(text("tool.path.device.id: there are several Inverse3: ", join(inventory.devices), "; name one"));
  if (std::ranges::find(inventory.devices, id) == inventory.devices.end())
    throw_unknown("tool.path.device.id", id, inventory.devices);
  return id;
}

class Haply final : public DeviceDriver {
 public:
  Haply(const DeviceSettings& settings, DeviceSlots& slots)
      : address_(parse_address(settings.address)), settings_(settings), slots_(slots) {
    auto first = std::make_unique<Connection>(address_, settings.id, settings.service_damping, slots_, is_closing_);
    try {
      first->open();
      const HaplyState inventory = first->inventory(2000);
      id_ = choose(inventory, settings.id);
      const auto at = std::ranges::find(inventory.devices, id_) - inventory.devices.begin();
      model_ = inventory.models[static_cast<std::size_t>(at)];
    } catch (const boost::system::system_error& e) {
      refuse(address_, e.code().message());
    }
    thread_ = std::thread([this, first = std::move(first)]() mutable { run(std::move(first)); });
  }
  ~Haply() override {
    is_closing_ = true;
    thread_.join();
  }
  DeviceInfo info() const override {
    DeviceInfo out;
    out.max_force = kUsualForce;
    out.senses_turn = true;
    out.name = model_.empty() ? "Inverse3" : model_;
    out.serial = id_;
    return out;
  }

 private:
  /// A connection that is lost is opened again, once a second.
  void run(std::unique_ptr<Connection> connection) {
    const RealTimeThread on_time({.priority = kIoPriority, .locks_memory = false});  // as far as it is granted
    for (;;) {
      if (connection) connection->run(id_);
      connection.reset();
      slots_.health = DeviceHealth::gone;
      for (int i = 0; i < 50 && !is_closing_; ++i) std::this_thread::sleep_for(milliseconds(20));
      if (is_closing_) return;
      try {
        auto next = std::make_unique<Connection>(address_, id_, settings_.service_damping, slots_, is_closing_);
        next->open();
        const HaplyState inventory = next->inventory(2000);
        if (std::ranges::find(inventory.devices, id_) != inventory.devices.end()) connection = std::move(next);
      } catch (const std::exception&) {
        // Not there yet.
      }
    }
  }

  ServiceAddress address_;
  DeviceSettings settings_;
  DeviceSlots& slots_;
  std::string id_, model_;
  std::atomic<bool> is_closing_{false};
  std::thread thread_;
};

std::unique_ptr<DeviceDriver> open_haply(const DeviceSettings& settings, DeviceSlots& slots) {
  return std::make_unique<Haply>(settings, slots);
}

}  // namespace

std::unique_ptr<HapticDevice> make_haply_device(const DeviceOptions& options) {
  return make_live_device(options, open_haply);
}

std::vector<FoundDevice> find_haply_devices(const DeviceSettings& settings) {
  const ServiceAddress address = parse_address(settings.address);
  const std::atomic<bool> is_closing{false};
  DeviceSlots none;
  try {
    Connection service(address, settings.id, 0, none, is_closing);
    service.open();
    const HaplyState inventory = service.inventory(1000);
    std::vector<FoundDevice> out;
    for (std::size_t i = 0; i < inventory.devices.size(); ++i)
      out.push_back({"haply", inventory.devices[i], inventory.models[i], ""});
    return out;
  } catch (const boost::system::system_error& e) {
    return {{"haply", "", "",
             text("ws://", address.host, ":", address.port, ": ", e.code().message(),
                  "; is the Haply Inverse Service running?")}};
  }
}

}  // namespace kt
