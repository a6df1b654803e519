#pragma once
// A Haply Inverse Service without a device: the same messages, and behind them a hand that holds an Inverse3 (mass,
// spring and damper to a target). Faults are switched on while it runs.
#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/base/types.hpp"

namespace kt {

enum class HaplyFault { none, silent, nan, truncated, saturated, no_device, uncalibrated };

struct FakeHaplyOptions {
  unsigned short port = 0;                          ///< 0: any that is free
  std::vector<std::string> ids{"049D"};             ///< of the devices that are listed
  double mass = 0.1, damping = 3, stiffness = 300;  ///< hand and device [kg], [N s/m], [N/m]
  double delay = 0.5e-3;                            ///< from a message to the motors [s]
  std::size_t most_kept = 1u << 16;                 ///< of the forces that heard() gives: the newest
  double encoder_step = 1e-5;                       ///< [m]
  std::function<Vec3(double t)> target{};           ///< [m], device frame, t [s] since the first force; none: at rest
};

/// What the device was told.
struct HeardForce {
  double t = 0;  ///< [s] since the service began
  Vec3 force;    ///< [N]
};

/// Of all that it was told.
struct HeardSum {
  std::size_t messages = 0;
  double most_force = 0, most_step = 0;  ///< [N], from message to message
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
  double now() const;                ///< [s] since the service began
  HeardSum heard_sum() const;
  std::vector<HeardForce> heard() const;  ///< a copy
  Vec3 place() const;                     ///< of the device now
  double most_energy_given() const;       ///< largest work of the device on the hand so far [J]; >= 0
  int connections() const;                ///< so far

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace kt
