#include "haptics/driver/haply/haply_connection.hpp"

#include <utility>  // Boost 1.74's awaitable.hpp forgets it

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>

#include "haptics/driver/haply/haply_echo.hpp"

namespace kt {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;
using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr std::size_t kMostOnTheWay = 3;  // messages without an answer: a service that hangs is not flooded
constexpr std::int64_t kMs = 1'000'000;   // [ns]

Vec3 vector(const double (&v)[3]) noexcept { return {v[0], v[1], v[2]}; }

}  // namespace

struct HaplyConnection::Parts {
  explicit Parts(HaplySession& s) : session(s), socket(context), timer(context), echo(HaplyKey::vector) {
    if (DeviceReading before; session.slots.reading.read(before)) reading = before;  // its counts go on
  }

  /// Runs until `failed` is set; throws what it is.
  void settle(const error_code& failed) {
    context.restart();
    while (failed == asio::error::would_block && context.run_one() > 0) {
    }
    if (failed) throw boost::system::system_error(failed);
  }

  void open() {
    tcp::resolver resolver(context);
    auto& stream = beast::get_lowest_layer(socket);
    const auto found = resolver.resolve(session.address.host, session.address.port);
    stream.expires_after(milliseconds(2000));
    error_code failed = asio::error::would_block;
    stream.async_connect(found, [&](error_code e, const tcp::endpoint&) { failed = e; });
    settle(failed);
    stream.socket().set_option(tcp::no_delay(true));
    stream.expires_never();
    socket.set_option(websocket::stream_base::timeout{milliseconds(2000), milliseconds(5000), false});
    socket.read_message_max(1 << 20);
    failed = asio::error::would_block;
    socket.async_handshake(session.address.host, "/", [&](error_code e) { failed = e; });
    settle(failed);
  }

  std::string take_text() {
    std::string out = beast::buffers_to_string(buffer.data());
    buffer.consume(buffer.size());
    return out;
  }

  /// Before run(): the next message within so long; none: it did not come, and is read on for.
  std::optional<HaplyState> next(int patience) {
    read();
    context.restart();
    const auto until = std::chrono::steady_clock::now() + milliseconds(patience);
    while (is_reading && std::chrono::steady_clock::now() < until && !session.is_closing)
      context.run_one_for(milliseconds(20));
    if (is_reading) return {};
    if (read_failed) throw boost::system::system_error(read_failed);
    try {
      return read_haply_state(take_text(), session.id, session.grip);
    } catch (const InputError&) {
      return HaplyState{};
    }
  }

  void read() {
    if (is_reading) return;
    is_reading = true;
    socket.async_read(buffer, [this](error_code e, std::size_t) {
      is_reading = false;
      read_failed = e;
      if (is_running) hear();
    });
  }

  void hear() {
    if (read_failed) return end();
    const std::int64_t now = monotonic_ns();
    if (on_the_way > 0) --on_the_way;
    heard_ns = now;
    take(take_text(), now);
    read();
  }

  void take(const std::string& message, std::int64_t now) {
    HaplyState state;
    try {
      state = read_haply_state(message, session.id, session.grip);
    } catch (const InputError&) {
      return;  // a frame that is none: the pose ages
    }
    if (state.is_full) {
      if (altered.empty() && !state.altered.empty())
        session.notes.add("the service was set to " + state.altered + " meanwhile: it is set back");
      altered = state.altered;
    }
    if (state.status) {
      status = *state.status;
      echo.heard(state.force, now);
    }
    is_gone = state.has_list && !state.status;
    if (const DeviceHealth health = judge(now); health != DeviceHealth::ok || state.x) session.slots.health = health;
    if (state.x) put(state, now);
  }

  void put(const HaplyState& state, std::int64_t now) {
    DeviceReading out = reading;
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
    if (const auto delay = echo.take_delay()) {
      out.delay = 1e-9 * static_cast<double>(*delay);
      ++out.delays;
    }
    out.echoed = state.force ? state.force->norm() : 0;
    out.most_echoed = std::max(reading.most_echoed, echo.most());
    reading = out;
    session.slots.reading.put(out);
  }

  /// What keeps forces from the device, but for their echo; ok: nothing.
  DeviceHealth trouble(std::int64_t now) const {
    constexpr std::int64_t kWakesUp = 500 * kMs;
    if (is_gone) return DeviceHealth::gone;
    if (!status.has_power) return DeviceHealth::unpowered;
    if (session.watch && session.watch->has_braked()) return DeviceHealth::fault;
    if (!status.is_calibrated) return DeviceHealth::uncalibrated;
    if (now - began_ns > kWakesUp && !(status.is_ready && status.is_started)) return DeviceHealth::not_ready;
    if (!altered.empty() || (session.watch && session.watch->is_scaled())) return DeviceHealth::altered;
    return DeviceHealth::ok;
  }

  DeviceHealth judge(std::int64_t now) {
    const DeviceHealth out = trouble(now);
    if (echo.is_proven() && !was_proven)
      session.notes.add(text("forces by set_cursor_force.", name_of(echo.key()), ", which the service repeats"));
    was_proven = echo.is_proven();
    return out == DeviceHealth::ok && !was_proven ? DeviceHealth::no_echo : out;
  }

  /// What is to be given now: nothing to a device that may not be moved, or whose service does not answer.
  DeviceOrder wanted(std::int64_t now) const {
    constexpr std::int64_t kSilent = 15 * kMs;
    if (session.is_closing || !echo.is_proven() || now - heard_ns > kSilent) return {};
    return session.slots.wanted(now);
  }

  void schedule(std::int64_t ns) {
    timer.expires_after(microseconds(ns / 1000));
    timer.async_wait([this](error_code e) {
      if (!e) tick();
    });
  }

  void tick() {
    constexpr std::int64_t kLook = 60'000;  // [ns]
    const std::int64_t now = monotonic_ns();
    if (session.is_closing) return close(now);
    if (now - heard_ns > 2000 * kMs) return end();  // it hangs: another connection may do
    if (now - sent_ns > 100 * kMs) on_the_way = 0;  // answers that are this late were never sent
    take_order();
    if (echo.is_proven())
      give(now);
    else
      prove(now);
    const bool is_stopped = now - order.at_ns > 2 * period_ns;
    const std::int64_t next = order.at_ns + period_ns;
    const std::int64_t wake = is_stopped  ? now + kMs / 2
                              : has_asked ? std::max(next + kLook / 3, now + kLook)
                                          : next - kAhead;
    schedule(std::max(kLook, wake - now));
  }

  void take_order() {
    DeviceOrder newest;
    if (!session.slots.order.read(newest) || newest.count == order.count) return;
    if (order.at_ns != 0) period_ns = std::clamp<std::int64_t>(newest.at_ns - order.at_ns, 100'000, 20 * kMs);
    order = newest;
    is_owed = true;
    has_asked = false;
  }

  /// A force once after each order; a question so long before the next one that its answer is a fresh pose then. A zero
  /// after a force always goes, however many answers are missing.
  void give(std::int64_t now) {
    const DeviceOrder force = wanted(now);
    const bool is_free = on_the_way < kMostOnTheWay;
    const bool lets_go = was_force && vector(force.force).isZero(0);
    const bool is_stopped = now - order.at_ns > 2 * period_ns;
    if (lets_go || (is_free && (is_owed || (is_stopped && now - sent_ns >= kMs))))
      send_force(force, now);
    else if (is_free && !is_stopped && !has_asked && now >= order.at_ns + period_ns - kAhead)
      ask(now);
  }

  /// One proof at a time, so that none is added to another; questions in between.
  void prove(std::int64_t now) {
    if (was_force) return send_force({}, now);
    if (on_the_way > 0 || now - sent_ns < 2 * kMs) return;
    if (trouble(now) != DeviceHealth::ok) return ask(now);
    DeviceOrder proof;
    for (int i = 0; i < 3; ++i) proof.force[i] = echo.proof()[i];
    send_force(proof, now);
    was_force = false;  // it is never let go of, being nothing
  }

  void send_force(const DeviceOrder& force, std::int64_t now) {
    echo.sent(vector(force.force), force.at_ns, now);
    was_force = !vector(force.force).isZero(0);
    is_owed = false;
    send(haply_force(session.id, force.force, echo.key()));
  }

  /// Once a second, sooner while something is altered, with the whole configuration, which is set back then.
  void ask(std::int64_t now) {
    has_asked = true;
    if (is_writing) return;  // no question in the place of a force
    const bool is_full = now - full_ns > (altered.empty() ? 1000 : 100) * kMs;
    if (is_full) full_ns = now;
    send(is_full && !altered.empty() ? haply_identities(session.id, session.service_damping)
                                     : haply_question(session.id, is_full));
  }

  void send(std::string message) {
    sent_ns = monotonic_ns();
    if (is_writing) {
      waiting = std::move(message);  // the newest replaces an older one
      return;
    }
    is_writing = true;
    ++on_the_way;
    writing = std::move(message);
    socket.async_write(asio::buffer(writing), [this](error_code e, std::size_t) {
      is_writing = false;
      if (e) return end();
      if (!waiting.empty()) send(std::exchange(waiting, {}));
    });
  }

  /// Zeros for 50 ms, whatever the order says; then goodbye.
  void close(std::int64_t now) {
    if (closing_since == 0) closing_since = now;
    if (now - closing_since > 50 * kMs) return end();
    send_force({}, now);
    schedule(2 * kMs);
  }

  void end() {
    if (is_over) return;
    is_over = true;
    timer.cancel();
    error_code none;
    beast::get_lowest_layer(socket).socket().shutdown(tcp::socket::shutdown_both, none);
    beast::get_lowest_layer(socket).close();
    context.stop();  // the socket's own timers would keep it for seconds
  }

  static constexpr std::int64_t kAhead = 300'000;  // [ns]

  HaplySession& session;
  asio::io_context context;
  websocket::stream<beast::tcp_stream> socket;
  asio::steady_timer timer;
  beast::flat_buffer buffer;
  error_code read_failed;
  std::string writing, waiting, altered;
  HaplyEcho echo;
  HaplyStatus status;
  DeviceReading reading;
  DeviceOrder order;       // the newest
  bool is_owed = false;    // its force has not been sent
  bool has_asked = false;  // since it came
  bool was_force = false;  // what was sent last was no zero
  bool was_proven = false, is_gone = false, is_reading = false, is_running = false, is_writing = false, is_over = false;
  std::size_t on_the_way = 0;  // messages
  std::int64_t sent_ns = 0, heard_ns = 0, full_ns = 0, began_ns = 0, closing_since = 0, period_ns = kMs;
};

HaplyConnection::HaplyConnection(HaplySession& session) : parts_(std::make_unique<Parts>(session)) { parts_->open(); }
HaplyConnection::~HaplyConnection() = default;

HaplyState HaplyConnection::inventory(int patience) {
  const auto until = std::chrono::steady_clock::now() + milliseconds(patience);
  HaplyState out;
  bool is_heard = false;
  for (;;) {
    const auto left = std::chrono::duration_cast<milliseconds>(until - std::chrono::steady_clock::now()).count();
    const auto state = left > 0 && !parts_->session.is_closing
                           ? parts_->next(static_cast<int>(is_heard ? std::min<long long>(left, 200) : left))
                           : std::nullopt;
    if (state) {
      is_heard = true;
      out = *state;
      if (state->status) parts_->status = *state->status;
      if (!out.devices.empty()) return out;
    } else if (!is_heard) {
      throw boost::system::system_error(asio::error::timed_out);
    } else if (left <= 0 || parts_->session.is_closing) {
      return out;
    }
    std::this_thread::sleep_for(milliseconds(100));
    parts_->socket.write(asio::buffer(haply_question("", true)));
  }
}

std::string HaplyConnection::introduce(HaplyKey key) {
  constexpr int kTries = 5, kAnswers = 4;
  Parts& p = *parts_;
  p.echo = HaplyEcho(key);
  p.socket.write(asio::buffer(haply_greeting(p.session.id, p.session.service_damping, key)));
  p.next(500);
  for (int i = 0; i < kTries && !p.session.is_closing; ++i) {
    p.socket.write(asio::buffer(haply_identities(p.session.id, p.session.service_damping)));
    p.socket.write(asio::buffer(haply_question(p.session.id, true)));
    std::optional<HaplyState> full;
    for (int k = 0; k < kAnswers; ++k) {
      const auto state = p.next(k < 2 ? 500 : 20);  // two answers are due
      if (state && state->is_full) full = state;
    }
    if (!full) return {};
    p.altered = full->altered;
    if (p.altered.empty()) break;
    std::this_thread::sleep_for(milliseconds(50));
  }
  return p.altered;
}

void HaplyConnection::run() {
  Parts& p = *parts_;
  p.began_ns = p.heard_ns = p.full_ns = monotonic_ns();
  p.is_running = true;
  p.read();
  p.schedule(0);
  p.context.restart();
  p.context.run();
}

}  // namespace kt
