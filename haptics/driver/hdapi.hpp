#pragma once
// The functions and numbers of OpenHaptics' HDAPI (libHD.so) that are used here, declared by ourselves. The numbers are
// those of hdDefines.h 3.00; copies of that header with others exist. Lengths are mm, forces N.
#include <cstdint>

#include "haptics/driver/vendor_library.hpp"

namespace kt::hd {

enum Name : unsigned {
  kButtons = 0x2000,
  kInkwell = 0x2002,
  kPosition = 0x2050,   // 3 doubles [mm]
  kVelocity = 0x2051,   // 3 doubles [mm/s]
  kTransform = 0x2052,  // 16 doubles, column-major [mm]
  kModel = 0x2501,
  kSerial = 0x2504,
  kWorkspace = 0x2551,         // 6 doubles: the least corner, the largest [mm]
  kCalibrationStyle = 0x2555,  // what hdUpdateCalibration can do
  kRate = 0x2600,              // [Hz]
  kMaxStiffness = 0x2602,      // [N/mm]
  kMaxForce = 0x2603,          // [N]
  kContinuousForce = 0x2604,   // [N]
  kMaxDamping = 0x2609,        // [N s/mm]
  kForce = 0x2700,             // 3 doubles [N]
  kForceOutput = 0x4000,
  kCalibrated = 0x5000,
  kNeedsUpdate = 0x5001,
  kNeedsHand = 0x5002,
};

/// Ways in which a device is calibrated: bits of kCalibrationStyle, of which hdUpdateCalibration takes one.
enum Style : int { kEncoderReset = 1, kAutomatic = 2, kInInkwell = 4 };

enum Error : unsigned { kNone = 0, kForceErrors = 0x0200, kDeviceErrors = 0x0300, kFrameErrors = 0x0400 };

constexpr unsigned kNoDevice = 0xFFFFFFFF;
constexpr std::uint16_t kFirst = 0xFFFF;  // largest priority
constexpr int kDone = 0, kContinue = 1;   // what a callback returns

struct ErrorInfo {
  unsigned code;
  int internal;
  unsigned device;
};

struct Library {
  explicit Library(const std::string& file) : loaded("openhaptics", file, {"libHD.so", "libHD.so.3.4", "libHD.so.3"}) {
    loaded.find(init, "hdInitDevice");
    loaded.find(disable_device, "hdDisableDevice");
    loaded.find(make_current, "hdMakeCurrentDevice");
    loaded.find(begin_frame, "hdBeginFrame");
    loaded.find(end_frame, "hdEndFrame");
    loaded.find(get_doubles, "hdGetDoublev");
    loaded.find(get_integers, "hdGetIntegerv");
    loaded.find(get_string, "hdGetString");
    loaded.find(set_doubles, "hdSetDoublev");
    loaded.find(enable, "hdEnable");
    loaded.find(disable, "hdDisable");
    loaded.find(schedule, "hdScheduleAsynchronous");
    loaded.find(unschedule, "hdUnschedule");
    loaded.find(start_scheduler, "hdStartScheduler");
    loaded.find(stop_scheduler, "hdStopScheduler");
    loaded.find(check_calibration, "hdCheckCalibration");
    loaded.find(update_calibration, "hdUpdateCalibration");
    loaded.find(get_error, "hdGetError");
    loaded.check();
  }

  VendorLibrary loaded;
  unsigned (*init)(const char* name);
  void (*disable_device)(unsigned device);
  void (*make_current)(unsigned device);
  void (*begin_frame)(unsigned device);
  void (*end_frame)(unsigned device);
  void (*get_doubles)(unsigned name, double* values);
  void (*get_integers)(unsigned name, int* values);
  const char* (*get_string)(unsigned name);
  void (*set_doubles)(unsigned name, const double* values);
  void (*enable)(unsigned name);
  void (*disable)(unsigned name);
  unsigned long (*schedule)(int (*callback)(void*), void* data, std::uint16_t priority);
  void (*unschedule)(unsigned long handle);
  void (*start_scheduler)();
  void (*stop_scheduler)();
  unsigned (*check_calibration)();
  void (*update_calibration)(unsigned style);
  ErrorInfo (*get_error)();
};

}  // namespace kt::hd
