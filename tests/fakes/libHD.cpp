// Stands for 3D Systems' libHD.so: the functions that the driver asks for, one scheduler thread at 1 kHz. mm, N.
#include <cmath>
#include <cstring>
#include <deque>
#include <limits>
#include <mutex>
#include <thread>

#include "tests/fakes/fake_device.hpp"

namespace {

using kt::fake::Device;
using kt::fake::Fault;

struct ErrorInfo {
  unsigned code;
  int internal;
  unsigned device;
};

Device device;
std::mutex mutex;
std::deque<ErrorInfo> errors;
int (*callback)(void*) = nullptr;
void* callback_data = nullptr;
std::atomic<bool> is_running{false};
std::thread scheduler;
bool is_calibrated_by_hand = false;

void report(unsigned code) {
  const std::lock_guard lock(mutex);
  errors.push_back({code, 0, 0});
}

void run() {
  std::int64_t due = kt::fake::now_ns();
  while (is_running) {
    switch (device.fault.load()) {
      case Fault::hang:  // once
        kt::fake::sleep_until_ns(kt::fake::now_ns() + 200'000'000);
        device.fault = Fault::none;
        break;
      case Fault::dead:
        kt::fake::sleep_until_ns(kt::fake::now_ns() + 5'000'000);
        continue;
      case Fault::gone:
        report(0x0302);
        break;
      case Fault::saturated:
        report(0x0201);
        break;
      default:
        break;
    }
    int (*f)(void*) = nullptr;
    void* data = nullptr;
    {
      const std::lock_guard lock(mutex);
      f = callback;
      data = callback_data;
    }
    if (f && f(data) == 0) {
      const std::lock_guard lock(mutex);
      callback = nullptr;
    }
    due = std::max(due + 1'000'000, kt::fake::now_ns() - 1'000'000);
    kt::fake::sleep_until_ns(due);
  }
}

}  // namespace

extern "C" {
Device* fake_device() { return &device; }

unsigned hdInitDevice(const char* name) {
  if (name && std::strcmp(name, "nobody") == 0) {
    report(0x0302);
    return 0xFFFFFFFF;
  }
  ++device.opened;
  return 0;
}
void hdDisableDevice(unsigned) { ++device.closed; }
void hdMakeCurrentDevice(unsigned) {}
void hdBeginFrame(unsigned) {}
void hdEndFrame(unsigned) {}
void hdGetDoublev(unsigned name, double* out) {
  const double bad = std::numeric_limits<double>::quiet_NaN();
  const bool is_bad = device.fault == Fault::nan;
  switch (name) {
    case 0x2050:
      if (is_bad) device.is_bad_pose_asked = true;
      for (int i = 0; i < 3; ++i) out[i] = is_bad && i == 1 ? bad : 1e3 * device.x[i];
      return;
    case 0x2051:
      out[0] = 1, out[1] = 2, out[2] = 3;
      return;
    case 0x2052: {  // a quarter turn about z: the stylus' x is the device's y
      const double frame[16] = {
          0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 1e3 * device.x[0], 1e3 * device.x[1], 1e3 * device.x[2], 1};
      std::memcpy(out, frame, sizeof frame);
      return;
    }
    case 0x2551: {
      const double box[6] = {-80, -60, -35, 80, 60, 35};
      std::memcpy(out, box, sizeof box);
      return;
    }
    case 0x2602:
      *out = 0.4;
      return;
    case 0x2603:
      *out = 3.3;
      return;
    case 0x2604:
      *out = 0.88;
      return;
    case 0x2609:
      *out = 0.004;
      return;
    default:
      report(0x0100);
  }
}
void hdGetIntegerv(unsigned name, int* out) {
  switch (name) {
    case 0x2000:
      *out = device.buttons;
      return;
    case 0x2555:
      *out = device.styles;
      return;
    case 0x2600:
      *out = 1000;
      return;
    default:
      report(0x0100);
  }
}
const char* hdGetString(unsigned name) { return name == 0x2501 ? "Fake Touch" : name == 0x2504 ? "220-1" : ""; }
void hdSetDoublev(unsigned name, const double* f) {
  if (name == 0x2700) device.get(f[0], f[1], f[2]);
}
void hdEnable(unsigned name) {
  if (name == 0x4000) device.is_force_on = true;
}
void hdDisable(unsigned name) {
  if (name == 0x4000) device.is_force_on = false;
}
unsigned long hdScheduleAsynchronous(int (*f)(void*), void* data, unsigned short) {
  const std::lock_guard lock(mutex);
  callback = f;
  callback_data = data;
  return 1;
}
void hdUnschedule(unsigned long) {
  const std::lock_guard lock(mutex);
  callback = nullptr;
}
void hdStartScheduler() {
  if (is_running.exchange(true)) return;
  scheduler = std::thread(run);
}
void hdStopScheduler() {
  if (is_running.exchange(false)) scheduler.join();
}
unsigned hdCheckCalibration() {
  if (device.fault == Fault::uncalibrated) {
    is_calibrated_by_hand = true;  // from now on
    return 0x5002;
  }
  return is_calibrated_by_hand ? 0x5001 : 0x5000;
}
void hdUpdateCalibration(unsigned style) {
  const bool is_one = style == 1 || style == 2 || style == 4;  // never several
  if (is_one && (device.styles & static_cast<int>(style)) != 0) is_calibrated_by_hand = false;
}
ErrorInfo hdGetError() {
  const std::lock_guard lock(mutex);
  if (errors.empty()) return {0, 0, 0};
  const ErrorInfo first = errors.front();
  errors.pop_front();
  return first;
}
}
