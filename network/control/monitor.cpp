#include "network/control/monitor.hpp"

#include <cstdint>
#include <cstring>

namespace kt {

ConnectionMonitor::ConnectionMonitor(zmq::context_t& context, zmq::socket_t& watched, const std::string& name,
                                     int events)
    : watched_(watched), own_(context, zmq::socket_type::pair) {
  const std::string place = "inproc://" + name;
  if (::zmq_socket_monitor(watched.handle(), place.c_str(), events) != 0) throw zmq::error_t();
  own_.set(zmq::sockopt::linger, 0);
  own_.connect(place);
}

ConnectionMonitor::~ConnectionMonitor() { ::zmq_socket_monitor(watched_.handle(), nullptr, 0); }

void ConnectionMonitor::take(const std::function<void(int event, int value)>& take_one) {
  zmq::message_t what, where;
  while (own_.recv(what, zmq::recv_flags::dontwait) && own_.recv(where, zmq::recv_flags::none)) {
    std::uint16_t event = 0;
    std::int32_t value = 0;
    if (what.size() < sizeof event + sizeof value) continue;
    std::memcpy(&event, what.data(), sizeof event);
    std::memcpy(&value, static_cast<const char*>(what.data()) + sizeof event, sizeof value);
    take_one(event, value);
  }
}

}  // namespace kt
