#include "apps/console/host_and_port.hpp"

#include <algorithm>
#include <cctype>

#include "core/base/error.hpp"

namespace kt {

std::pair<std::string, int> host_and_port(const std::string& given, const std::string& what) {
  const std::size_t colon = given.rfind(':');
  const bool is_bracketed = !given.empty() && given.front() == '[';
  const bool has_port = colon != std::string::npos && (!is_bracketed || given[colon - 1] == ']') &&
                        (is_bracketed || given.find(':') == colon);
  std::string host = has_port ? given.substr(0, colon) : given;
  const std::string port = has_port ? given.substr(colon + 1) : std::to_string(kUsualPort);
  if (is_bracketed && host.size() > 2 && host.back() == ']') host = host.substr(1, host.size() - 2);
  const bool is_number = !port.empty() && port.size() <= 5 &&
                         std::ranges::all_of(port, [](char c) { return std::isdigit(static_cast<unsigned char>(c)); });
  if (host.empty() || !is_number || std::stoi(port) > 65535)
    throw InputError(
        text(what, " is \"", given, "\", must be ADDRESS:PORT with a port of 0 .. 65535, as 127.0.0.1:", kUsualPort));
  return {host, std::stoi(port)};
}

}  // namespace kt
