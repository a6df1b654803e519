// Stands for Force Dimension's libdhd.so: calls that wait for a bus at 1 kHz. SI units.
#include <cmath>
#include <limits>

#include "tests/fakes/fake_device.hpp"

namespace {

using kt::fake::Device;
using kt::fake::Fault;

Device device;
std::int64_t due = 0;
bool is_open[2] = {};

/// The bus; false: the device is not there.
bool wait_for_bus() {
  if (device.fault == Fault::hang) {  // once
    kt::fake::sleep_until_ns(kt::fake::now_ns() + 200'000'000);
    device.fault = Fault::none;
  }
  if (device.fault == Fault::gone) device.get(0, 0, 0);  // no bus, no power
  if (device.fault == Fault::dead || device.fault == Fault::gone) return false;
  due = std::max(due + 1'000'000, kt::fake::now_ns());
  kt::fake::sleep_until_ns(due);
  return true;
}

}  // namespace

extern "C" {
Device* fake_device() { return &device; }

int dhdGetDeviceCount() { return device.fault == Fault::gone ? 0 : device.count.load(); }
int dhdOpenID(char id) {
  if (id < 0 || id >= device.count || device.fault == Fault::gone || device.fault == Fault::dead) return -1;
  is_open[static_cast<int>(id)] = true;
  ++device.opened;
  return id;
}
int dhdClose(char id) {
  ++device.closed;
  is_open[static_cast<int>(id)] = false;
  return 0;
}
const char* dhdGetSystemName(char) { return "fake omega.6"; }
int dhdGetSerialNumber(unsigned short* out, char id) {
  *out = static_cast<unsigned short>(4001 + id);
  return 0;
}
bool dhdHasWrist(char) { return true; }
bool dhdHasActiveWrist(char) { return true; }
int dhdEnableForce(unsigned char on, char) {
  device.is_force_on = on != 0;
  if (on) device.forces_off = 0;
  return 0;
}
int dhdSetGravityCompensation(int, char) { return 0; }
double dhdGetMaxForce(char) { return -1; }
int dhdGetPosition(double* x, double* y, double* z, char) {
  if (!wait_for_bus()) return -1;
  const bool is_bad = device.fault == Fault::nan;
  if (is_bad) device.is_bad_pose_asked = true;
  *x = device.x[0];
  *y = is_bad ? std::numeric_limits<double>::quiet_NaN() : device.x[1].load();
  *z = device.x[2];
  return 0;
}
int dhdGetOrientationFrame(double rows[3][3], char) {  // a quarter turn about z: the stylus' x is the device's y
  const double frame[3][3] = {{0, -1, 0}, {1, 0, 0}, {0, 0, 1}};
  for (int i = 0; i < 9; ++i) rows[i / 3][i % 3] = frame[i / 3][i % 3];
  return 0;
}
int dhdGetLinearVelocity(double* x, double* y, double* z, char) {
  *x = 1e-3, *y = 2e-3, *z = 3e-3;
  return 0;
}
unsigned dhdGetButtonMask(char) { return static_cast<unsigned>(device.buttons); }
int dhdGetStatus(int* out, char) {
  if (device.fault == Fault::dead || device.fault == Fault::gone) return -1;
  for (int i = 0; i < 17; ++i) out[i] = 0;
  for (const int well : {0, 1, 2, 12}) out[well] = 1;  // power, connected, started, wrist ready
  out[3] = device.fault == Fault::uncalibrated ? 0 : 1;
  out[5] = device.forces_off == 0;
  out[14] = device.forces_off;
  if (device.wrong >= 0) out[device.wrong] = out[device.wrong] == 0;
  return 0;
}
int dhdSetForce(double x, double y, double z, char) {
  if (device.fault == Fault::gone) device.get(0, 0, 0);
  if (device.fault == Fault::dead || device.fault == Fault::gone) return -1;
  device.get(x, y, z);
  return device.fault == Fault::saturated ? 2 : 0;
}
int dhdSetForceAndTorqueAndGripperForce(double x, double y, double z, double, double, double, double, char id) {
  return dhdSetForce(x, y, z, id);
}
const char* dhdErrorGetLastStr() { return "no device found"; }
}
