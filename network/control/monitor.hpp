#pragma once
// What becomes of a ZeroMQ socket's connections.
#include <functional>
#include <string>
#include <zmq.hpp>

namespace kt {

/// Tells of a socket's connections as they come and go (zmq_socket_monitor).
class ConnectionMonitor {
 public:
  /// @param name    of its own in the context
  /// @param events  ZMQ_EVENT_... to tell of
  ConnectionMonitor(zmq::context_t& context, zmq::socket_t& watched, const std::string& name, int events);
  ~ConnectionMonitor();
  ConnectionMonitor(const ConnectionMonitor&) = delete;
  ConnectionMonitor& operator=(const ConnectionMonitor&) = delete;

  /// For zmq::poll.
  void* handle() { return own_.handle(); }

  /// Hands over all that wait: event and its value.
  void take(const std::function<void(int event, int value)>& take_one);

 private:
  zmq::socket_t& watched_;
  zmq::socket_t own_;
};

}  // namespace kt
