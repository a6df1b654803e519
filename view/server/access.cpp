// Who may speak to the server.
#include <algorithm>

#include "view/server/server.hpp"

namespace kt {

bool is_own_origin(const std::string& origin, const std::string& host) {
  return !host.empty() && (origin == "http://" + host || origin == "https://" + host);
}

bool is_own_host(const std::string& host, const ServerOptions& options) {
  const std::size_t colon = host.rfind(':');
  const bool has_port = colon != std::string::npos && host.back() != ']';
  const std::string name = has_port ? host.substr(0, colon) : host, port = has_port ? host.substr(colon + 1) : "80";
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  if (name.empty() || port.empty() || port.size() > 5 || !std::ranges::all_of(port, is_digit)) return false;
  if (!options.token.empty()) return true;  // who has it was told it
  return name == "localhost" || name == "[::1]" || name == options.address || name == "127.0.0.1";
}

bool is_same_secret(const std::string& given, const std::string& wanted) {
  unsigned different = given.size() != wanted.size();
  for (std::size_t i = 0; i < wanted.size(); ++i)
    different |= static_cast<unsigned>(static_cast<unsigned char>(wanted[i]) ^
                                       static_cast<unsigned char>(i < given.size() ? given[i] : 0));
  return different == 0;
}

}  // namespace kt
