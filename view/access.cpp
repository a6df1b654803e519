// Who may speak to the server.
#include <algorithm>

#include "view/server.hpp"

namespace kt {

bool is_own_origin(const std::string& origin, const std::string& host) {
  return !host.empty() && (origin == "http://" + host || origin == "https://" + host);
}

bool is_own_host(const std::string& host, const ServerOptions& options) {
  const std::size_t colon = host.rfind(':');
  const bool has_port = colon != std::string::npos && host.back() != ']';
  const std::string name = has_port ? host.substr(0, colon) : host;
  if (name.empty()) return false;
  if (!options.token.empty()) return true;  // which a page of others does not have
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
