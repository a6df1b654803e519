#include "haptics/driver/device_frame.hpp"

#include <cmath>

#include "core/base/error.hpp"

namespace kt {

Mat3 device_axes(const std::string& axes) {
  const auto refuse = [&](const char* why) {
    throw InputError(text("tool.path.device.axes \"", axes, "\": ", why,
                          "; write the device's axes that are the world's x, y and z, each once, as XYZ or X-ZY"));
  };
  Mat3 out = Mat3::Zero();
  int row = 0;
  double sign = 1;
  for (const char c : axes) {
    if (c == '-' && sign > 0) {
      sign = -1;
      continue;
    }
    if (c < 'X' || c > 'Z' || row == 3) refuse("is not three of X, Y and Z");
    out(row++, c - 'X') = sign;
    sign = 1;
  }
  if (row != 3 || sign < 0) refuse("is not three of X, Y and Z");
  if (!(out.transpose() * out).isIdentity(0)) refuse("names an axis twice");
  if (out.determinant() < 0) refuse("is left-handed: it would mirror every turn; change one sign");
  return out;
}

}  // namespace kt
