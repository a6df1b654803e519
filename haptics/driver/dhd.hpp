#pragma once
// The functions and numbers of Force Dimension's DHD (libdhd.so) that are used here, declared by ourselves after dhdc.h
// 3.7 (the last that drives a Falcon) and 3.17. SI units. Every function ends in a device number, which callers in C
// have to give. Negative results are errors; 1 (called too soon) and 2 (a motor is at its limit) are none.
#include "haptics/driver/vendor_library.hpp"

namespace kt::dhd {

/// Of dhdGetStatus.
enum Status {
  kPower = 0,
  kConnected = 1,
  kReset = 3,
  kForceOn = 5,
  kError = 9,
  kWristReady = 12,
  kForceOffCause = 14,
  kStatusCount = 17  // 16 before 3.8
};

/// Why the controller has switched its force off.
enum ForceOff { kNotOff, kButton, kVelocity, kWatchdog, kSoftware, kUsb, kDeadMan };

constexpr unsigned char kOn = 1, kOff = 0;

struct Library {
  explicit Library(const std::string& file) : loaded("forcedimension", file, {"libdhd.so", "libdhd.so.3"}) {
    loaded.find(count, "dhdGetDeviceCount");
    loaded.find(open, "dhdOpenID");
    loaded.find(close, "dhdClose");
    loaded.find(name, "dhdGetSystemName");
    loaded.find(serial, "dhdGetSerialNumber");
    loaded.find(has_wrist, "dhdHasWrist");
    loaded.find(has_active_wrist, "dhdHasActiveWrist");
    loaded.find(enable_force, "dhdEnableForce");
    loaded.find(compensate_gravity, "dhdSetGravityCompensation");
    loaded.find_if_there(max_force, "dhdGetMaxForce");  // not in 3.7
    loaded.find(position, "dhdGetPosition");
    loaded.find(orientation, "dhdGetOrientationFrame");
    loaded.find(velocity, "dhdGetLinearVelocity");
    loaded.find(buttons, "dhdGetButtonMask");
    loaded.find(status, "dhdGetStatus");
    loaded.find(set_force, "dhdSetForce");
    loaded.find(set_wrench, "dhdSetForceAndTorqueAndGripperForce");
    loaded.find(last_error, "dhdErrorGetLastStr");
    loaded.check();
  }

  VendorLibrary loaded;
  int (*count)();
  int (*open)(char id);
  int (*close)(char id);
  const char* (*name)(char id);
  int (*serial)(unsigned short* out, char id);
  bool (*has_wrist)(char id);
  bool (*has_active_wrist)(char id);
  int (*enable_force)(unsigned char on, char id);
  int (*compensate_gravity)(int on, char id);
  double (*max_force)(char id);  // negative: no limit set; null: an older version
  int (*position)(double* x, double* y, double* z, char id);
  int (*orientation)(double (*rows)[3], char id);
  int (*velocity)(double* x, double* y, double* z, char id);
  unsigned (*buttons)(char id);
  int (*status)(int* out, char id);
  int (*set_force)(double x, double y, double z, char id);
  int (*set_wrench)(double x, double y, double z, double tx, double ty, double tz, double gripper, char id);
  const char* (*last_error)();
};

}  // namespace kt::dhd
