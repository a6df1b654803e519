#include "view/server/server.hpp"

#include <charconv>
#include <utility>  // before asio, whose awaitable.hpp forgets it

#include <boost/asio.hpp>
#include <boost/beast.hpp>
#include <chrono>
#include <deque>
#include <future>
#include <limits>
#include <map>
#include <optional>

#include "core/base/error.hpp"
#include "core/base/numbers.hpp"
#include "core/base/visible_text.hpp"
#include "view/server/page_files.hpp"
#include "view/server/page_message.hpp"
#include "view/server/peer_user.hpp"

namespace kt {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using tcp = asio::ip::tcp;
using Error = beast::error_code;
using Request = http::request<http::string_body>;
using Response = http::response<http::string_body>;
using Head = http::header<true>;
using Bytes = std::shared_ptr<const std::string>;

constexpr std::size_t kMostWaiting = 64;    // messages to one page that are no frames
constexpr std::size_t kMostStrangers = 64;  // connections that have not been let in
constexpr std::size_t kLongestHead = 16384, kLongestName = 255;
constexpr auto kPeriod = std::chrono::microseconds(16667);
constexpr auto kForHead = std::chrono::seconds(10), kForUpload = std::chrono::seconds(120);
constexpr auto kForRest = std::chrono::seconds(2);  // of what nobody reads

/// The value of NAME in "/path?NAME=value&...", as it stands there.
std::string query_value(const std::string& target, const std::string& name) {
  std::size_t at = target.find('?');
  while (at != std::string::npos) {
    const std::size_t end = target.find('&', at + 1);
    const std::string part = target.substr(at + 1, end == std::string::npos ? end : end - at - 1);
    if (part.starts_with(name + '=')) return part.substr(name.size() + 1);
    at = end;
  }
  return {};
}

/// A value of a query as browsers' URLSearchParams write it: "%20" and "+" as a space; a wrong escape stays as it is.
std::string unescaped(const std::string& s) {
  std::string out;
  for (std::size_t i = 0; i < s.size(); ++i) {
    const bool is_escape = s[i] == '%' && i + 2 < s.size() && is_hex_digit(s[i + 1]) && is_hex_digit(s[i + 2]);
    unsigned code = 0;
    if (is_escape) std::from_chars(s.data() + i + 1, s.data() + i + 3, code, 16);
    out += is_escape ? static_cast<char>(code) : s[i] == '+' ? ' ' : s[i];
    if (is_escape) i += 2;
  }
  return out;
}

std::string json_error(const std::string& what) {
  std::string out = R"({"error": ")";
  for (const char c : visible(what)) out += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
  return out + "\"}";
}

/// One WebSocket. One write at a time; of frames only the newest waits.
class Page : public std::enable_shared_from_this<Page> {
 public:
  Page(beast::tcp_stream&& stream, int id, ServerHandler& handler, std::function<void(int)> left)
      : socket_(std::move(stream)), id_(id), handler_(handler), left_(std::move(left)) {}

  void open(const Request& request, std::function<void()> joined) {
    beast::get_lowest_layer(socket_).expires_never();
    socket_.set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
    socket_.read_message_max(kLongestMessage);
    socket_.async_accept(request, [self = shared_from_this(), joined](Error error) {
      if (error) return self->close();
      joined();
      self->read();
    });
  }

  /// Opened only to say why it is closed: a browser hides the answers to a request that is refused.
  void refuse(const Request& request, const std::string& why) {
    beast::get_lowest_layer(socket_).expires_after(kForHead);
    socket_.async_accept(request, [self = shared_from_this(), why](Error error) {
      if (!error)
        self->socket_.async_close({websocket::close_code::try_again_later, why}, [self](Error) { self->close(); });
    });
  }

  void send(Server::Kind kind, Bytes content, bool is_frame) {
    if (is_closed_) return;
    if (is_frame)
      frame_ = {kind, std::move(content)};
    else if (waiting_.size() < kMostWaiting)
      waiting_.push_back({kind, std::move(content)});
    else
      return close();
    write();
  }

  void close() {
    if (std::exchange(is_closed_, true)) return;
    Error ignored;
    beast::get_lowest_layer(socket_).socket().close(ignored);
    left_(id_);
  }

 private:
  struct Message {
    Server::Kind kind = Server::Kind::text;
    Bytes content;
  };

  void read() {
    socket_.async_read(buffer_, [self = shared_from_this()](Error error, std::size_t) {
      if (error) return self->close();
      const std::string message = beast::buffers_to_string(self->buffer_.data());
      self->buffer_.consume(self->buffer_.size());
      if (!self->is_closed_) self->handler_.received(self->id_, message);
      if (!self->is_closed_) self->read();
    });
  }

  void write() {
    if (is_writing_ || is_closed_) return;
    if (!waiting_.empty()) {
      now_ = std::move(waiting_.front());
      waiting_.pop_front();
    } else if (frame_.content) {
      now_ = std::exchange(frame_, {});
    } else {
      return;
    }
    is_writing_ = true;
    socket_.binary(now_.kind == Server::Kind::bytes);
    socket_.async_write(asio::buffer(*now_.content), [self = shared_from_this()](Error error, std::size_t) {
      self->is_writing_ = false;
      self->now_ = {};
      if (error) return self->close();
      self->write();
    });
  }

  websocket::stream<beast::tcp_stream> socket_;
  int id_;
  ServerHandler& handler_;
  std::function<void(int)> left_;
  beast::flat_buffer buffer_;
  std::deque<Message> waiting_;
  Message frame_, now_;
  bool is_writing_ = false, is_closed_ = false;
};

/// Of a request, as far as its head tells.
struct Asked {
  explicit Asked(const Head& head)
      : target(head.target()),
        path(target.substr(0, target.find('?'))),
        is_upload(path == "/mesh" && head.method() == http::verb::post),
        is_page(path == "/live") {}
  std::string value(const std::string& name) const { return unescaped(query_value(target, name)); }
  std::string target, path;
  bool is_upload, is_page;
};

Response json_response(http::status status, const std::string& json) {
  Response out{status, 11};
  out.set(http::field::content_type, "application/json");
  out.body() = json;
  return out;
}

Response refusal(http::status status, const std::string& why) { return json_response(status, json_error(why)); }

}  // namespace

struct Server::Parts {
  class Connection;
  struct Stranger {
    std::string address;
    std::weak_ptr<Connection> connection;
  };

  Parts(const ServerOptions& o, ServerHandler& h)
      : options(o), handler(h), acceptor(context), timer(context), again(context) {}

  void accept();
  void make_room();
  void let_in(int id) { strangers.erase(id); }
  std::optional<Response> refused(const Head& head, bool is_own_user) const;
  Response answer(const Head& head) const;
  void open_page(beast::tcp_stream&& stream, const Request& request);
  void upload(std::string name, std::string bytes, std::function<void(Response)> done);
  void tick();

  ServerOptions options;
  ServerHandler& handler;
  std::map<int, Stranger> strangers;  // the oldest first; goes after what the context holds
  asio::io_context context{1};
  tcp::acceptor acceptor;
  asio::steady_timer timer, again;
  std::map<int, std::shared_ptr<Page>> pages;
  int next_page = 1, next_connection = 1;
  unsigned short port = 0;
  const std::atomic<bool>* stop = nullptr;
  bool is_looking = false;
  std::future<void> looking;  // at a mesh that was dropped
};

/// One HTTP connection, until it ends or becomes a page's WebSocket. Of a request the head is looked at first: the body
/// of one that is not let in is never kept.
class Server::Parts::Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(tcp::socket&& socket, Parts& server, int id, bool is_own_user)
      : stream_(std::move(socket)), server_(server), id_(id), is_own_user_(is_own_user) {}
  ~Connection() { server_.let_in(id_); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void read() {
    parser_.emplace();
    parser_->header_limit(kLongestHead);
    parser_->body_limit(std::numeric_limits<std::uint64_t>::max());  // looked at below; "none" is 0 in Boost 1.74
    stream_.expires_after(kForHead);
    http::async_read_header(stream_, buffer_, *parser_, [self = shared_from_this()](Error error, std::size_t) {
      if (!error) self->take_head();
    });
  }
  void close() { stream_.close(); }

 private:
  void take_head() {
    const Head& head = parser_->get();
    const Asked asked(head);
    if (auto refused = server_.refused(head, is_own_user_)) return write(std::move(*refused));
    if (asked.is_page && websocket::is_upgrade(parser_->get()) && parser_->is_done())
      return server_.open_page(std::move(stream_), parser_->release());
    if (!asked.is_upload) return write(server_.answer(head));
    const auto length = parser_->content_length();
    if (length && *length > kLargestUpload)
      return write(
          refusal(http::status::payload_too_large, text("a file may have at most ", kLargestUpload >> 20, " MiB")));
    if (server_.is_looking)
      return write(
          refusal(http::status::service_unavailable, "another mesh is being looked at; try again in a moment"));
    read_upload(asked.value("name"));
  }

  void read_upload(const std::string& name) {
    server_.is_looking = true;
    server_.let_in(id_);
    parser_->body_limit(kLargestUpload);
    stream_.expires_after(kForUpload);
    http::async_read(stream_, buffer_, *parser_, [self = shared_from_this(), name](Error error, std::size_t) {
      if (error) {
        self->server_.is_looking = false;
        if (error == http::error::body_limit)
          self->write(refusal(http::status::payload_too_large, "a file may have at most 64 MiB"));
        return;
      }
      self->stream_.expires_never();
      self->server_.upload(name, std::move(self->parser_->get().body()),
                           [self](Response response) { self->write(std::move(response)); });
    });
  }

  void write(Response response) {
    is_kept_ = parser_->is_done() && parser_->get().keep_alive();
    response_ = std::move(response);
    response_.keep_alive(is_kept_);
    response_.set(http::field::cache_control, "no-store");
    response_.set("X-Content-Type-Options", "nosniff");
    response_.set("Referrer-Policy", "no-referrer");  // the address may have a token
    response_.prepare_payload();
    stream_.expires_after(kForHead);
    http::async_write(stream_, response_, [self = shared_from_this()](Error error, std::size_t) {
      if (error) return;
      if (self->is_kept_) return self->read();
      self->stream_.socket().shutdown(tcp::socket::shutdown_send, error);
      self->stream_.expires_after(kForRest);
      self->skip();
    });
  }

  /// A body that nobody wants: closed at once, the answer would be lost on its way.
  void skip() {
    stream_.async_read_some(asio::buffer(rest_), [self = shared_from_this()](Error error, std::size_t) {
      if (!error) self->skip();
    });
  }

  beast::tcp_stream stream_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::string_body>> parser_;
  Response response_;
  Parts& server_;
  int id_;
  bool is_own_user_, is_kept_ = false;
  std::array<char, 4096> rest_;
};

/// Looked at before anything else of a request. What does something is let in from a page of our own alone, and with
/// the token; without one, from this user of this computer.
std::optional<Response> Server::Parts::refused(const Head& head, bool is_own_user) const {
  const auto no = [](const char* why) { return refusal(http::status::forbidden, why); };
  const std::string host(head[http::field::host]);
  if (!is_own_host(host, options)) return no("this server has another name");
  if (options.token.empty() && !is_own_user)
    return no("another user of this computer: kilotouch view --token T lets you in");
  const Asked asked(head);
  if (!asked.is_upload && !asked.is_page) return std::nullopt;
  if (!is_own_origin(std::string(head[http::field::origin]), host)) return no("not from a page of this server");
  if (!options.token.empty() && !is_same_secret(asked.value("token"), options.token))
    return no("the page's address has not the server's token: open the one that kilotouch printed");
  if (asked.is_upload && asked.value("name").size() > kLongestName)
    return refusal(http::status::bad_request, text("a file's name may have at most ", kLongestName, " bytes"));
  return std::nullopt;
}

Response Server::Parts::answer(const Head& head) const {
  const Asked asked(head);
  if (head.method() != http::verb::get && head.method() != http::verb::head)
    return refusal(http::status::method_not_allowed, "only GET, and POST of a mesh");
  for (const PageFile& file : page_files())
    if (asked.path == file.path || (asked.path == "/" && file.path == "/index.html")) {
      Response out = json_response(http::status::ok, std::string(file.content));
      out.set(http::field::content_type, beast::string_view(file.type.data(), file.type.size()));
      out.set("Content-Security-Policy",
              "default-src 'self'; img-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; "
              "connect-src 'self' ws: wss:; frame-ancestors 'none'");
      return out;
    }
  return refusal(http::status::not_found, "no such page");
}

void Server::Parts::open_page(beast::tcp_stream&& stream, const Request& request) {
  const int id = next_page++;
  const auto page = std::make_shared<Page>(std::move(stream), id, handler, [this](int which) {
    if (pages.erase(which) > 0) handler.left(which);
  });
  if (static_cast<int>(pages.size()) >= kMostPages)
    return page->refuse(request, text(kMostPages, " pages are open, more are not served: close one"));
  page->open(request, [this, id, page] {
    pages[id] = page;
    handler.joined(id);
  });
}

/// In a thread of its own: pages go on meanwhile.
void Server::Parts::upload(std::string name, std::string bytes, std::function<void(Response)> done) {
  looking = std::async(std::launch::async, [this, name = std::move(name), bytes = std::move(bytes), done] {
    Response response;
    try {
      response = json_response(http::status::ok, handler.uploaded(name, bytes));
    } catch (const std::exception& e) {
      response = refusal(http::status::bad_request, e.what());
    }
    asio::post(context, [this, done, response = std::move(response)] {
      is_looking = false;
      done(response);
    });
  });
}

/// Of the address that has the most connections the oldest one goes: who opens many shuts nobody else out.
void Server::Parts::make_room() {
  while (strangers.size() >= kMostStrangers) {
    std::map<std::string, int> counts;
    for (const auto& [id, stranger] : strangers) ++counts[stranger.address];
    const auto most = std::ranges::max_element(counts, {}, [](const auto& count) { return count.second; });
    const auto oldest =
        std::ranges::find_if(strangers, [&](const auto& entry) { return entry.second.address == most->first; });
    const auto connection = oldest->second.connection.lock();
    strangers.erase(oldest);
    if (connection) connection->close();
  }
}

void Server::Parts::accept() {
  acceptor.async_accept([this](Error error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    const tcp::endpoint peer = error ? tcp::endpoint() : socket.remote_endpoint(error);
    if (error) {  // as when there are no more file descriptors: not asked again at once
      again.expires_after(std::chrono::milliseconds(20));
      again.async_wait([this](Error ended) {
        if (!ended) accept();
      });
      return;
    }
    make_room();
    Error ignored;
    socket.set_option(tcp::no_delay(true), ignored);
    const int id = next_connection++;
    const std::string address = peer.address().to_string();
    const bool is_own_user = options.token.empty() && is_peer_of_this_user(address, peer.port(), port);
    const auto connection = std::make_shared<Connection>(std::move(socket), *this, id, is_own_user);
    strangers[id] = {address, connection};
    connection->read();
    accept();
  });
}

void Server::Parts::tick() {
  handler.tick();
  if (stop->load()) {
    context.stop();
    return;
  }
  timer.expires_at(std::max(timer.expiry() + kPeriod, std::chrono::steady_clock::now()));
  timer.async_wait([this](Error error) {
    if (!error) tick();
  });
}

Server::Server(const ServerOptions& options, ServerHandler& handler)
    : parts_(std::make_unique<Parts>(options, handler)) {
  if (!is_loopback(options.address) && options.token.size() < 8)
    throw InputError(text("--listen ", options.address,
                          " can be reached from other computers: --token T is needed, of 8 letters or more"));
  Error error;
  const std::string name = options.address == "localhost" ? "127.0.0.1" : options.address;
  const auto address = asio::ip::make_address(name, error);
  if (error) throw InputError(text("--listen: ", options.address, " is no address; as 127.0.0.1 or 0.0.0.0"));
  const tcp::endpoint endpoint(address, options.port);
  tcp::acceptor& acceptor = parts_->acceptor;
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(asio::socket_base::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error == asio::error::address_in_use)
    throw InputError(text("--port: ", options.port, " is in use; take another, or 0 for any that is free"));
  if (error) throw InputError(text("--listen ", options.address, ":", options.port, ": ", error.message()));
  parts_->port = acceptor.local_endpoint().port();
  parts_->options.address = address.to_string();
}

Server::~Server() = default;

void Server::run(const std::atomic<bool>& stop) {
  parts_->stop = &stop;
  parts_->accept();
  parts_->timer.expires_at(std::chrono::steady_clock::now());
  parts_->tick();
  parts_->context.run();
  parts_->pages.clear();
  if (parts_->looking.valid()) parts_->looking.wait();
}

unsigned short Server::port() const { return parts_->port; }

std::string Server::url() const {
  const ServerOptions& o = parts_->options;
  const std::string host = o.address == "0.0.0.0" ? "localhost" : o.address == "::" ? "::1" : o.address;
  const bool is_v6 = host.find(':') != std::string::npos;
  return text("http://", is_v6 ? "[" : "", host, is_v6 ? "]" : "", ":", parts_->port, "/",
              o.token.empty() ? "" : "?token=" + o.token);
}

void Server::send(int page, Kind kind, std::shared_ptr<const std::string> content, bool is_frame) {
  const auto found = parts_->pages.find(page);
  if (found == parts_->pages.end()) return;
  const std::shared_ptr<Page> kept = found->second;  // sending may close it
  kept->send(kind, std::move(content), is_frame);
}

void Server::send_all(Kind kind, std::shared_ptr<const std::string> content, bool is_frame) {
  std::vector<int> all;
  for (const auto& [id, page] : parts_->pages) all.push_back(id);
  for (const int id : all) send(id, kind, content, is_frame);
}

int Server::num_pages() const { return static_cast<int>(parts_->pages.size()); }

}  // namespace kt
