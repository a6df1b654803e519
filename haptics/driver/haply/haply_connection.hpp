#pragma once
// One connection to Haply's service: from its handshake until it is lost. The service sends one state for each message
// that it gets, so our rate is the rate: a force goes out once after each tick, a question before the next.
#include <memory>
#include <string>

#include "haptics/driver/haply/haply_messages.hpp"
#include "haptics/driver/haply/haply_service.hpp"

namespace kt {

/// What a driver's connections have in common.
struct HaplySession {
  HaplyAddress address;
  std::string id;    ///< of the device; empty: not chosen yet
  std::string grip;  ///< of the device; empty: it has none
  double service_damping = 0;
  DeviceSlots& slots;
  HaplyNotes& notes;
  const std::atomic<bool>& is_closing;
  const HaplyWatch* watch = nullptr;
};

class HaplyConnection {
 public:
  /// Throws boost::system::system_error: nobody is there, or it is no WebSocket.
  explicit HaplyConnection(HaplySession& session);
  ~HaplyConnection();

  /// The first message; when it lists no device, further ones until it does. @param patience [ms]
  /// Throws boost::system::system_error when nothing comes at all.
  HaplyState inventory(int patience);

  /// Tells the service who we are and that places are to be as they are, and reads it back.
  /// @returns what stays altered; empty: nothing, or the service does not say
  std::string introduce(HaplyKey key);

  /// Until the connection is lost, or the driver closes: zeros are written for 50 ms then.
  void run();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace kt
