#pragma once
// Addresses as ZeroMQ writes them.
#include <string>

namespace kt {

struct Endpoint {
  std::string text;     ///< "tcp://127.0.0.1:7000", "tcp://[::1]:7000"
  std::string shown;    ///< the same for people: "127.0.0.1:7000"
  bool is_six = false;  ///< IPv6
};

/// An address or name; of a name's addresses an IPv4 one is taken first. Throws InputError: not known, port outside 0
/// to 65535.
/// @param port  0: any that is free
Endpoint find_endpoint(const std::string& host, int port);

}  // namespace kt
