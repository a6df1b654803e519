#pragma once
// Which addresses only this computer reaches.
#include <string>

namespace kt {

/// Whether only this computer reaches the address: localhost, ::1 or 127.x.y.z.
inline bool is_loopback(const std::string& address) {
  return address == "localhost" || address == "::1" ||
         (address.starts_with("127.") && address.find_first_not_of("0123456789.") == std::string::npos);
}

}  // namespace kt
