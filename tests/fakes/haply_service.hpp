#pragma once
// A Haply Inverse Service without a device, made from what its maker documents (3.5; docs.haply.co/inverseSDK/service),
// not from our driver: one state for each message, commands of a tick that add up and are repeated, settings of a
// session that a desk program may put on again, settings by HTTP, a channel of events. Behind it a hand holds an
// Inverse3 (mass, spring and damper to a target). Each of these can be set wrong, and faults be switched on.
#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/base/types.hpp"

namespace kt {

enum class HaplyFault {
  none,
  silent,
  nan,
  truncated,
  saturated,
  no_device,
  uncalibrated,
  unpowered,
  not_ready,
  deaf,    ///< takes no force any more, and repeats none
  scaled,  ///< a desk program puts a mount on that is twice as large, and takes it off when it is told to
};

struct FakeGrip {
  std::string id{};
  std::string paired{};  ///< with that device; empty: it does not say
  Quaternion turn = Quaternion::Identity();
};

struct FakeHaplyOptions {
  unsigned short port = 0;                          ///< 0: any that is free
  std::vector<std::string> ids{"049D"};             ///< of the devices that are listed
  double mass = 0.1, damping = 3, stiffness = 300;  ///< hand and device [kg], [N s/m], [N/m]
  double delay = 0.5e-3;                            ///< from a message to the motors [s]
  std::size_t most_kept = 1u << 16;                 ///< of the forces that heard() gives: the newest
  double encoder_step = 1e-5;                       ///< [m]
  std::function<Vec3(double t)> target{};           ///< [m], device frame, t [s] since the first force; none: at rest
  // As documented; each set wrong once.
  bool knows_vector = true, knows_values = true;  ///< names of a force that it takes
  bool repeats = true;                            ///< what it was commanded last
  bool is_old = false;                            ///< 3.1: no type, mount, preset, basis in its configuration
  std::string kept{};                             ///< what stays whatever is asked: mount basis preset transform gate
  double force_scale = 1;                         ///< global
  bool has_http = true, has_events = true;
  bool is_in_use = false, is_started = true;
  std::string type = "inverse3";
  std::vector<FakeGrip> grips{{"61", "", Quaternion::Identity()}};
  double tick = 2e-4;  ///< [s] within which forces add up
};

/// What the device was told.
struct HeardForce {
  double t = 0;  ///< [s] since the service began
  Vec3 force;    ///< [N] of the message; of another name than it knows: not heard
};

/// Of all that it was told.
struct HeardSum {
  std::size_t messages = 0;              ///< with a force
  std::size_t questions = 0;             ///< without
  std::size_t unknown = 0;               ///< with a force under a name that it does not know
  double most_force = 0, most_step = 0;  ///< [N], from message to message
  double most_in_a_tick = 0;             ///< sum of the forces of one tick, largest [N]
  bool is_finite = true;
  double last = 0;  ///< [N]
};

class FakeHaply {
 public:
  explicit FakeHaply(FakeHaplyOptions options);
  ~FakeHaply();

  unsigned short port() const;
  std::string address() const;       ///< ws://localhost:PORT
  void set_fault(HaplyFault fault);  ///< from now on
  void hang(int milliseconds);       ///< no answer so long
  void die();                        ///< the connection is cut, and none is taken
  void live();                       ///< connections are taken again
  void send_event(const std::string& json);
  int listeners() const;  ///< to events, now
  double now() const;     ///< [s] since the service began
  HeardSum heard_sum() const;
  std::vector<HeardForce> heard() const;  ///< a copy
  Vec3 place() const;                     ///< of the device now
  double most_energy_given() const;       ///< largest work of the device on the hand so far [J]; >= 0
  int connections() const;                ///< to states, so far

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace kt
