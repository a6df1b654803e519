#include "network/control/endpoint.hpp"

#include <netdb.h>
#include <sys/socket.h>

#include <array>

#include "core/base/error.hpp"

namespace kt {

Endpoint find_endpoint(const std::string& host, int port) {
  if (port < 0 || port > 65535) throw InputError(text(host, ": port is ", port, "; must be in [0, 65535]"));
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int error = ::getaddrinfo(host.c_str(), nullptr, &hints, &found))
    throw InputError(text(host, ": no such address or name: ", ::gai_strerror(error)));
  const addrinfo* best = found;
  while (best && best->ai_family != AF_INET) best = best->ai_next;
  if (!best) best = found;
  std::array<char, NI_MAXHOST> number{};
  const int error =
      ::getnameinfo(best->ai_addr, best->ai_addrlen, number.data(), number.size(), nullptr, 0, NI_NUMERICHOST);
  const bool six = best->ai_family == AF_INET6;
  ::freeaddrinfo(found);
  if (error != 0) throw InputError(text(host, ": no such address or name: ", ::gai_strerror(error)));
  const std::string address = text(six ? "[" : "", number.data(), six ? "]" : "");
  return {text("tcp://", address, ":", port == 0 ? "*" : std::to_string(port)), text(address, ":", port), six};
}

}  // namespace kt
