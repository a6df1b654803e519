#pragma once
#include <string>
#include <utility>

namespace kt {

/// "127.0.0.1:7700", "[::1]:7700", "host:7700"; without a port the usual one. @throws InputError naming `what`
std::pair<std::string, int> host_and_port(const std::string& text, const std::string& what);

constexpr int kUsualPort = 7700;

}  // namespace kt
