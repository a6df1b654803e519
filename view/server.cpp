#include "view/server.hpp"

#include <utility>  // before asio, whose awaitable.hpp forgets it

#include <boost/asio.hpp>
#include <boost/beast.hpp>
#include <chrono>
#include <deque>
#include <map>
#include <optional>

#include "core/base/error.hpp"
#include "core/base/numbers.hpp"
#include "core/base/visible_text.hpp"
#include "view/page_files.hpp"
#include "view/page_message.hpp"

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
using Bytes = std::shared_ptr<const std::string>;

constexpr std::size_t kMostWaiting = 64;  // messages to one page that are no frames
constexpr int kMostConnections = 64;      // of all kinds at once
constexpr auto kPeriod = std::chrono::microseconds(16667);

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

/// "%20" as a space; a wrong escape stays as it is.
std::string unescaped(const std::string& s) {
  std::string out;
  for (std::size_t i = 0; i < s.size(); ++i) {
    const bool is_escape = s[i] == '%' && i + 2 < s.size() && is_hex_digit(s[i + 1]) && is_hex_digit(s[i + 2]);
    out += is_escape ? static_cast<char>(std::stoi(s.substr(i + 1, 2), nullptr, 16)) : s[i];
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

  /// A browser tells a page nothing of a refused WebSocket: it is opened and closed with the reason.
  void refuse(const Request& request, const std::string& why) {
    is_closed_ = true;
    beast::get_lowest_layer(socket_).expires_after(std::chrono::seconds(30));
    socket_.async_accept(request, [self = shared_from_this(), why](Error error) {
      if (error) return;
      self->socket_.async_close({websocket::close_code::try_again_later, why}, [self](Error) {});
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

}  // namespace

struct Server::Parts {
  Parts(const ServerOptions& o, ServerHandler& h) : options(o), handler(h), acceptor(context), timer(context) {}

  void accept();
  bool may(const Request& request, bool changes) const;
  Response answer(const Request& request);
  void tick();

  ServerOptions options;
  ServerHandler& handler;
  asio::io_context context{1};
  tcp::acceptor acceptor;
  asio::steady_timer timer;
  std::map<int, std::shared_ptr<Page>> pages;
  int next_page = 1, connections = 0;
  unsigned short port = 0;
  const std::atomic<bool>* stop = nullptr;
};

namespace {

/// One HTTP connection, until it ends or becomes a page's WebSocket.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  using Upgrade = std::function<void(beast::tcp_stream&&, Request&&)>;
  using Answer = std::function<Response(const Request&)>;
  Connection(tcp::socket&& socket, Answer answer, std::function<bool(const Request&)> may_upgrade, Upgrade upgrade,
             std::function<void()> ended)
      : stream_(std::move(socket)),
        answer_(std::move(answer)),
        may_upgrade_(std::move(may_upgrade)),
        upgrade_(std::move(upgrade)),
        ended_(std::move(ended)) {}
  ~Connection() { ended_(); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void read() {
    parser_.emplace();
    parser_->header_limit(16384);
    parser_->body_limit(kLargestUpload);
    stream_.expires_after(std::chrono::seconds(30));
    http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](Error error, std::size_t) {
      if (error == http::error::body_limit) return self->refuse();
      if (error) return;
      Request request = self->parser_->release();
      if (websocket::is_upgrade(request) && self->may_upgrade_(request))
        return self->upgrade_(std::move(self->stream_), std::move(request));
      self->write(self->answer_(request));
    });
  }

 private:
  void refuse() {
    Response out{http::status::payload_too_large, 11};
    out.set(http::field::content_type, "application/json");
    out.body() = json_error(text("a file may have at most ", kLargestUpload >> 20, " MiB"));
    out.keep_alive(false);
    write(std::move(out));
  }
  void write(Response response) {
    response_ = std::move(response);
    response_.prepare_payload();
    http::async_write(stream_, response_, [self = shared_from_this()](Error error, std::size_t) {
      if (!error && self->response_.keep_alive()) return self->read();
      self->stream_.socket().shutdown(tcp::socket::shutdown_send, error);
    });
  }

  beast::tcp_stream stream_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::string_body>> parser_;
  Response response_;
  Answer answer_;
  std::function<bool(const Request&)> may_upgrade_;
  Upgrade upgrade_;
  std::function<void()> ended_;
};

std::string field(const Request& request, http::field name) { return std::string(request[name]); }

}  // namespace

/// @param changes  the request does something: then from a page of our own, and with the token
bool Server::Parts::may(const Request& request, bool changes) const {
  const std::string host = field(request, http::field::host);
  if (!is_own_host(host, options)) return false;
  if (!changes) return true;
  if (!is_own_origin(field(request, http::field::origin), host)) return false;
  return options.token.empty() ||
         is_same_secret(unescaped(query_value(std::string(request.target()), "token")), options.token);
}

Response Server::Parts::answer(const Request& request) {
  Response out{http::status::ok, request.version()};
  out.keep_alive(request.keep_alive());
  out.set(http::field::cache_control, "no-store");
  out.set("X-Content-Type-Options", "nosniff");
  out.set(
      "Content-Security-Policy",
      "default-src 'self'; img-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; connect-src 'self' ws: wss:");
  out.set(http::field::content_type, "application/json");
  const auto say = [&](http::status status, const std::string& what) {
    out.result(status);
    out.body() = json_error(what);
    return out;
  };
  const std::string target(request.target()), path = target.substr(0, target.find('?'));
  const bool is_upload = path == "/mesh" && request.method() == http::verb::post;
  if (!may(request, is_upload || path == "/live"))
    return say(http::status::forbidden, "not from a page of this server, or without its token");
  if (is_upload) {
    try {
      out.body() = handler.uploaded(unescaped(query_value(target, "name")), request.body());
      return out;
    } catch (const std::exception& e) {
      return say(http::status::bad_request, e.what());
    }
  }
  if (request.method() != http::verb::get && request.method() != http::verb::head)
    return say(http::status::method_not_allowed, "only GET, and POST of a mesh");
  for (const PageFile& file : page_files())
    if (path == file.path || (path == "/" && file.path == "/index.html")) {
      out.set(http::field::content_type, beast::string_view(file.type.data(), file.type.size()));
      out.body() = std::string(file.content);
      return out;
    }
  return say(http::status::not_found, "no such page");
}

void Server::Parts::accept() {
  acceptor.async_accept([this](Error error, tcp::socket socket) {
    if (error == asio::error::operation_aborted) return;
    if (!error && connections < kMostConnections) {
      ++connections;
      Error ignored;
      socket.set_option(tcp::no_delay(true), ignored);
      std::make_shared<Connection>(
          std::move(socket), [this](const Request& request) { return answer(request); },
          [this](const Request& request) {
            const std::string target(request.target());
            return target.substr(0, target.find('?')) == "/live" && may(request, true);
          },
          [this](beast::tcp_stream&& stream, Request&& request) {
            const int id = next_page++;
            const auto page = std::make_shared<Page>(std::move(stream), id, handler, [this](int which) {
              if (pages.erase(which) > 0) handler.left(which);
            });
            if (static_cast<int>(pages.size()) >= kMostPages)
              return page->refuse(request, text(kMostPages, " pages are open already; close one of them"));
            page->open(request, [this, id, page] {
              pages[id] = page;
              handler.joined(id);
            });
          },
          [this] { --connections; })
          ->read();
    }
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
}

Server::~Server() = default;

void Server::run(const std::atomic<bool>& stop) {
  parts_->stop = &stop;
  parts_->accept();
  parts_->timer.expires_at(std::chrono::steady_clock::now());
  parts_->tick();
  parts_->context.run();
  parts_->pages.clear();
}

unsigned short Server::port() const { return parts_->port; }

std::string Server::url() const {
  const ServerOptions& o = parts_->options;
  const bool is_v6 = o.address.find(':') != std::string::npos;
  return text("http://", is_v6 ? "[" : "", o.address == "0.0.0.0" ? "localhost" : o.address, is_v6 ? "]" : "", ":",
              parts_->port, "/", o.token.empty() ? "" : "?token=" + o.token);
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
