#include "view/server/peer_user.hpp"

#include <arpa/inet.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <vector>

namespace kt {
namespace {

/// As the kernel prints an address: words of 32 bits in hexadecimal, the bytes as they lie in memory.
template <std::size_t N>
std::string hex_words(const std::array<std::uint32_t, N>& words) {
  std::string out;
  for (const std::uint32_t word : words) {
    char digits[9];
    std::snprintf(digits, sizeof digits, "%08X", word);
    out += digits;
  }
  return out;
}

/// How the tables write the address: of IPv4 both as itself and as one of IPv6.
std::vector<std::string> table_names(const std::string& address) {
  std::array<std::uint32_t, 1> v4{};
  if (inet_pton(AF_INET, address.c_str(), v4.data()) == 1)
    return {hex_words(v4), hex_words(std::array<std::uint32_t, 4>{0, 0, htonl(0xFFFF), v4[0]})};
  std::array<std::uint32_t, 4> v6{};
  if (inet_pton(AF_INET6, address.c_str(), v6.data()) == 1) return {hex_words(v6)};
  return {};
}

std::string hex_port(unsigned short port) {
  char digits[5];
  std::snprintf(digits, sizeof digits, "%04X", port);
  return digits;
}

}  // namespace

bool is_peer_of_this_user(const std::string& address, unsigned short port, unsigned short own_port) {
  const std::string own_end = ":" + hex_port(own_port);
  for (const std::string& name : table_names(address)) {
    const std::string its_end = name + ":" + hex_port(port);
    for (const char* table : {"/proc/net/tcp", "/proc/net/tcp6"}) {
      std::ifstream rows(table);
      for (std::string row; std::getline(rows, row);) {
        std::istringstream words(row);
        std::string number, local, remote, state, queues, timer, retries, timeout;
        unsigned user = 0;
        unsigned long inode = 0;
        words >> number >> local >> remote >> state >> queues >> timer >> retries >> user >> timeout >> inode;
        if (!words || local != its_end || !remote.ends_with(own_end)) continue;
        return inode != 0 && (user == geteuid() || user == 0);  // of a closed one no user is told: 0
      }
    }
  }
  return false;
}

}  // namespace kt
