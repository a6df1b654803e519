#pragma once
// Which user of this computer holds the other end of a connection: who listens on 127.0.0.1 is reached by all of them.
#include <string>

namespace kt {

/// Whether the other end belongs to this user, or to root: Linux tells it in /proc/net/tcp. False when it belongs to
/// another one, was closed, is on another computer, or cannot be found.
/// @param address, port  of the other end, as "127.0.0.1" or "::1"
/// @param own_port       of this end
bool is_peer_of_this_user(const std::string& address, unsigned short port, unsigned short own_port);

}  // namespace kt
