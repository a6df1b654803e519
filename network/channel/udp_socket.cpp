#include "network/channel/udp_socket.hpp"

#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

#include "core/base/error.hpp"

namespace kt {
namespace {

static_assert(sizeof(Peer::bytes) >= sizeof(sockaddr_in6));

/// Room for a large model at once; the system may give less (net.core.rmem_max).
constexpr int kBufferBytes = 4 << 20;

const sockaddr* as_address(const Peer& peer) { return reinterpret_cast<const sockaddr*>(peer.bytes.data()); }

sockaddr* as_address(Peer& peer) { return reinterpret_cast<sockaddr*>(peer.bytes.data()); }

std::string why(int error) { return std::strerror(error); }

int open_socket(const Peer& peer) {
  const int descriptor = ::socket(as_address(peer)->sa_family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (descriptor < 0) throw InputError(text(text_of(peer), ": no UDP socket: ", why(errno)));
  for (const auto& [forced, plain] : {std::pair{SO_RCVBUFFORCE, SO_RCVBUF}, std::pair{SO_SNDBUFFORCE, SO_SNDBUF}})
    if (::setsockopt(descriptor, SOL_SOCKET, forced, &kBufferBytes, sizeof kBufferBytes) != 0)
      ::setsockopt(descriptor, SOL_SOCKET, plain, &kBufferBytes, sizeof kBufferBytes);
  return descriptor;
}

}  // namespace

std::string text_of(const Peer& peer) {
  std::array<char, NI_MAXHOST> host{};
  std::array<char, NI_MAXSERV> port{};
  if (peer.size == 0 || ::getnameinfo(as_address(peer), peer.size, host.data(), host.size(), port.data(), port.size(),
                                      NI_NUMERICHOST | NI_NUMERICSERV | NI_DGRAM) != 0)
    return "none";
  const bool six = as_address(peer)->sa_family == AF_INET6;
  return text(six ? "[" : "", host.data(), six ? "]" : "", ":", port.data());
}

Peer find_peer(const std::string& host, int port) {
  if (port < 0 || port > 65535) throw InputError(text(host, ": port is ", port, "; must be in [0, 65535]"));
  addrinfo hints{};
  hints.ai_socktype = SOCK_DGRAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* found = nullptr;
  if (const int error = ::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found))
    throw InputError(text(host, ": no such address or name: ", ::gai_strerror(error)));
  const addrinfo* best = found;
  while (best && best->ai_family != AF_INET) best = best->ai_next;
  if (!best) best = found;
  Peer peer;
  peer.size = std::min(best->ai_addrlen, static_cast<std::uint32_t>(peer.bytes.size()));
  std::memcpy(peer.bytes.data(), best->ai_addr, peer.size);
  ::freeaddrinfo(found);
  return peer;
}

UdpSocket UdpSocket::bound(const std::string& address, int port) {
  const Peer own = find_peer(address, port);
  UdpSocket socket(open_socket(own));
  if (::bind(socket.descriptor_, as_address(own), own.size) != 0) {
    if (errno == EADDRINUSE)
      throw InputError(text(text_of(own), ": the UDP port is in use; take another, or 0 for any that is free"));
    if (errno == EADDRNOTAVAIL) throw InputError(text(address, " is not an address of this computer"));
    throw InputError(text(text_of(own), ": cannot listen: ", why(errno)));
  }
  return socket;
}

UdpSocket UdpSocket::connected_to(const std::string& host, int port) {
  const Peer peer = find_peer(host, port);
  UdpSocket socket(open_socket(peer));
  if (::connect(socket.descriptor_, as_address(peer), peer.size) != 0)
    throw InputError(text(text_of(peer), ": no way there: ", why(errno)));
  return socket;
}

UdpSocket::UdpSocket(UdpSocket&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

UdpSocket& UdpSocket::operator=(UdpSocket&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

UdpSocket::~UdpSocket() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

bool UdpSocket::receive(std::vector<std::uint8_t>& datagram, Peer& from, int timeout_ms) {
  using Clock = std::chrono::steady_clock;
  const auto until = Clock::now() + std::chrono::milliseconds(timeout_ms);
  for (int refused = 0; refused < 16;) {
    from = Peer{};
    datagram.resize(kMostDatagram);
    socklen_t size = sizeof from.bytes;
    const ssize_t got = ::recvfrom(descriptor_, datagram.data(), datagram.size(), 0, as_address(from), &size);
    if (got >= 0) {
      from.size = size;
      datagram.resize(static_cast<std::size_t>(got));
      return true;
    }
    if (errno != EAGAIN && errno != EWOULDBLOCK) {  // that an earlier datagram found nobody, mostly
      ++refused;
      continue;
    }
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()).count();
    if (left <= 0) break;
    pollfd wait{descriptor_, POLLIN, 0};
    ::poll(&wait, 1, static_cast<int>(left));
  }
  datagram.clear();
  return false;
}

bool UdpSocket::send(std::span<const std::uint8_t> datagram, const Peer& to) {
  ssize_t sent = 0;
  do sent = ::sendto(descriptor_, datagram.data(), datagram.size(), MSG_NOSIGNAL, as_address(to), to.size);
  while (sent < 0 && errno == EINTR);
  return sent >= 0;
}

bool UdpSocket::send(std::span<const std::uint8_t> datagram) {
  ssize_t sent = 0;
  int tries = 0;
  do  // the first try may only tell that an earlier datagram found nobody
    sent = ::send(descriptor_, datagram.data(), datagram.size(), MSG_NOSIGNAL);
  while (sent < 0 && (errno == EINTR || errno == ECONNREFUSED) && ++tries < 3);
  return sent >= 0;
}

std::uint16_t UdpSocket::port() const {
  Peer own;
  socklen_t size = sizeof own.bytes;
  if (::getsockname(descriptor_, as_address(own), &size) != 0) return 0;
  return as_address(own)->sa_family == AF_INET6
             ? ntohs(reinterpret_cast<const sockaddr_in6*>(own.bytes.data())->sin6_port)
             : ntohs(reinterpret_cast<const sockaddr_in*>(own.bytes.data())->sin_port);
}

Peer UdpSocket::peer() const {
  Peer peer;
  socklen_t size = sizeof peer.bytes;
  peer.size = ::getpeername(descriptor_, as_address(peer), &size) == 0 ? size : 0;
  return peer;
}

}  // namespace kt
