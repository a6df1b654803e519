#pragma once
// The web server of the view: pages over HTTP, one WebSocket a page. Boost.Beast is in server.cpp alone; one thread.
#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "core/base/loopback.hpp"

namespace kt {

struct ServerOptions {
  std::string address = "127.0.0.1";
  unsigned short port = 8080;  ///< 0: any that is free
  std::string token;  ///< that a page must bring; required when others than this computer can reach the address
};

constexpr std::size_t kLargestUpload = std::size_t{64} << 20;  // bytes
constexpr int kMostPages = 16;                                 // the next one is opened to be told so, and closed

/// What the server asks. In the thread of run() but for uploaded(); what is thrown as InputError goes to the page as
/// one line.
class ServerHandler {
 public:
  virtual ~ServerHandler() = default;
  virtual void joined(int page) = 0;
  virtual void received(int page, const std::string& message) = 0;
  virtual void left(int page) = 0;
  /// A file was dropped into a page. In another thread, one at a time. @returns the JSON to answer with
  virtual std::string uploaded(const std::string& name, const std::string& bytes) = 0;
  virtual void tick() = 0;  ///< some 60 times a second
};

class Server {
 public:
  /// Opens the port. Throws InputError: in use, not an address of this computer, no token.
  Server(const ServerOptions& options, ServerHandler& handler);
  ~Server();

  /// Serves until `stop` is true.
  void run(const std::atomic<bool>& stop);

  unsigned short port() const;
  std::string url() const;

  enum class Kind { text, bytes };
  /// Queued; of a page that does not keep up the oldest frames are left out, of one that takes nothing at all the
  /// connection is closed.
  void send(int page, Kind kind, std::shared_ptr<const std::string> content, bool is_frame = false);
  void send_all(Kind kind, std::shared_ptr<const std::string> content, bool is_frame = false);
  int num_pages() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// Whether a page of this origin may speak to the server; an Origin header is "http://host:port", or "https://..."
/// where another program carries the page on.
/// @param host  the request's own Host header
bool is_own_origin(const std::string& origin, const std::string& host);

/// Whether a Host header names this server: else a name of others was pointed at it (DNS rebinding). With a token any
/// name will do: who rebinds one has no token. Any port: another program may carry it on (ssh -L, docker -p).
bool is_own_host(const std::string& host, const ServerOptions& options);

/// In a time that does not tell where two texts differ.
bool is_same_secret(const std::string& given, const std::string& wanted);

}  // namespace kt
