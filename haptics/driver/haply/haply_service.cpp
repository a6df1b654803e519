#include "haptics/driver/haply/haply_service.hpp"

#include <utility>  // Boost 1.74's awaitable.hpp forgets it

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>

#include "haptics/driver/haply/haply_messages.hpp"

namespace kt {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;
using std::chrono::milliseconds;

constexpr const char* kAddress = "ws://localhost:10001";
constexpr const char* kOlderHttpPort = "10000";  // before 3.5 settings had a port of their own
constexpr milliseconds kPatience{300};           // for one answer: the service is on this computer, or near
constexpr const char* kForceScale = "devices/force_scale";

/// Runs until `failed` is set.
void settle(asio::io_context& context, const error_code& failed) {
  context.restart();
  while (failed == asio::error::would_block && context.run_one() > 0) {
  }
}

/// The body of the answer to GET; empty: there is none. @param failed  out: nobody answers there
std::string get(const HaplyAddress& address, const std::string& port, const std::string& path, bool& failed) {
  asio::io_context context;
  tcp::resolver resolver(context);
  beast::tcp_stream stream(context);
  error_code e;
  const auto found = resolver.resolve(address.host, port, e);
  failed = true;
  if (e) return {};
  stream.expires_after(kPatience);
  e = asio::error::would_block;
  stream.async_connect(found, [&](error_code result, const tcp::endpoint&) { e = result; });
  settle(context, e);
  if (e) return {};
  http::request<http::empty_body> request(http::verb::get, path, 11);
  request.set(http::field::host, address.host + ":" + port);
  request.set(http::field::connection, "close");
  e = asio::error::would_block;
  http::async_write(stream, request, [&](error_code result, std::size_t) { e = result; });
  settle(context, e);
  if (e) return {};
  beast::flat_buffer buffer;
  http::response_parser<http::string_body> answer;
  answer.body_limit(1 << 20);
  e = asio::error::would_block;
  http::async_read(stream, buffer, answer, [&](error_code result, std::size_t) { e = result; });
  settle(context, e);
  if (e && e != http::error::end_of_stream) return {};
  failed = false;
  return answer.get().result() == http::status::ok ? answer.get().body() : std::string();
}

/// For a terminal: in one line, nothing that moves the cursor, not too long.
std::string shown(const std::string& from) {
  std::string out = from.substr(0, 160);
  for (char& c : out)
    if (static_cast<unsigned char>(c) < ' ' || c == 127) c = ' ';
  return out;
}

}  // namespace

HaplyAddress parse_haply_address(const std::string& address) {
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

std::optional<double> ask_haply_setting(const HaplyAddress& address, const std::string& key) {
  std::vector<std::string> ports{address.port};
  if (parse_haply_address("").port == address.port) ports.push_back(kOlderHttpPort);
  for (const std::string& port : ports)
    for (const std::string& path :
         {"/settings/" + key, std::string("/settings?advanced=true"), std::string("/settings")}) {
      bool failed = false;
      const std::string answer = get(address, port, path, failed);
      if (const auto value = read_haply_setting(answer, key)) return value;
      if (failed) break;  // nobody is there, or it is no HTTP
    }
  return {};
}

void HaplyNotes::add(const std::string& note) {
  constexpr std::size_t kMost = 16;
  const std::scoped_lock lock(mutex_);
  const std::string line = shown(note);
  if (notes_.size() < kMost || notes_.contains(line)) ++notes_[line];
}

std::vector<std::string> HaplyNotes::list() const {
  const std::scoped_lock lock(mutex_);
  std::vector<std::string> out;
  for (const auto& [note, count] : notes_) out.push_back(count > 1 ? text(note, " (", count, " times)") : note);
  return out;
}

HaplyWatch::HaplyWatch(HaplyAddress address, std::string device, int events_port, bool tells_scale, HaplyNotes& notes)
    : address_(std::move(address)),
      device_(std::move(device)),
      events_port_(events_port),
      tells_scale_(tells_scale),
      notes_(notes),
      thread_([this] { run(); }) {}

HaplyWatch::~HaplyWatch() {
  is_closing_ = true;
  thread_.join();
}

void HaplyWatch::run() {
  while (!is_closing_) {
    try {
      listen();
    } catch (const std::exception&) {
      // No such channel, or it has ended: older services have none.
    }
    for (int i = 0; i < 100 && !is_closing_; ++i) {
      if (i % 50 == 0) look_at_scale();
      std::this_thread::sleep_for(milliseconds(20));
    }
  }
}

/// Until the channel ends. Events that nobody sends are waited for.
void HaplyWatch::listen() {
  asio::io_context context;
  tcp::resolver resolver(context);
  websocket::stream<beast::tcp_stream> socket(context);
  auto& stream = beast::get_lowest_layer(socket);
  stream.expires_after(kPatience);
  error_code failed = asio::error::would_block;
  stream.async_connect(resolver.resolve(address_.host, std::to_string(events_port_)),
                       [&](error_code e, const tcp::endpoint&) { failed = e; });
  settle(context, failed);
  if (failed) return;
  stream.expires_never();
  socket.set_option(websocket::stream_base::timeout{kPatience, websocket::stream_base::none(), false});
  socket.read_message_max(1 << 16);
  failed = asio::error::would_block;
  socket.async_handshake(address_.host, "/", [&](error_code e) { failed = e; });
  settle(context, failed);
  if (failed) return;
  beast::flat_buffer buffer;
  for (int turn = 0; !is_closing_;) {
    failed = asio::error::would_block;
    socket.async_read(buffer, [&](error_code e, std::size_t) { failed = e; });
    context.restart();
    while (failed == asio::error::would_block && !is_closing_) {
      context.run_one_for(milliseconds(20));
      if (++turn % 100 == 0) look_at_scale();
    }
    if (failed) break;
    take(beast::buffers_to_string(buffer.data()));
    buffer.consume(buffer.size());
  }
  stream.close();
  context.restart();
  context.run_for(kPatience);  // a read that is under way ends
}

void HaplyWatch::take(const std::string& message) {
  HaplyEvent event;
  try {
    event = read_haply_event(message);
  } catch (const InputError&) {
    return;
  }
  const bool is_ours = event.device == device_;
  if (is_ours && event.kind == "ebrake_triggered") has_braked_ = true;
  if (is_ours && event.kind == "ebrake_released") has_braked_ = false;
  if (event.level == "info" || event.level == "notice" || (!is_ours && event.name == "device-connected")) return;
  notes_.add(text("event ", event.level, ": ", event.name, event.kind.empty() ? "" : " (" + event.kind + ")",
                  event.device.empty() ? "" : " of " + event.device,
                  event.message.empty() ? "" : ": " + event.message));
}

void HaplyWatch::look_at_scale() {
  if (!tells_scale_) return;
  const auto scale = ask_haply_setting(address_, kForceScale);
  if (!scale) return;
  is_scaled_ = *scale != 1;
  if (is_scaled_) notes_.add(text(kForceScale, " is ", *scale, ": the service scales every force; set it to 1"));
}

}  // namespace kt
